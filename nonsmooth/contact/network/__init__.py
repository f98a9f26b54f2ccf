"""Contact problems of many bodies: the rows of a contact have two parts, one for each of its bodies, and no Delassus
matrix is made. ``problem`` says what is given and what is asked."""
