async function newSpace() { throw new Error("no spatial films yet"); }
