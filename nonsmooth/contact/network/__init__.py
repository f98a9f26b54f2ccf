"""Contact problems of many bodies: the rows of a contact have two parts, one for each of its bodies, and no Delassus
matrix is made.

    network = new(Network, d=2, n=3, m=contacts, n_b=bodies), solver = new(Solver, the same, fill=10 * bodies)
    n_c, i, j, J_i, J_j, b, mu, M, M_inv, v_free and P, the impulses to start from, are filled in,
    prepare_network(network, d)       parts of the rows, islands
    solve_network(network, solver, solver.direct.desk, d)
                                      P, v, and what is said of each island; or how many blocks of factors are wanted
    judge_network(network, d)         v and gamma of P, residuals

and with d, n = 3, 6 in space. ``problem`` says what is given and what is asked, ``solve`` how.
"""
