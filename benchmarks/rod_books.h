/* What the library books of a step beside its motion, for one closed contact with friction: works and the balance of
   energy, impulses, mode and its events, worst residual and penetration; NaN is looked for, and rest stays rest.
   Compiled with -DBOOKS; without it a step has its motion alone. */
#include <math.h>
typedef struct {
    double force, friction, normal, size, error, residual, penetration, P[2];
    int mode, slip;
    long events, several;
} Books;
static inline double larger(double a, double b) { return a > b ? a : b; }
/* u + the change that n parts make; 0 or u where that cancels to rounding. */
static inline double rounded(double u, double change, double size) {
    double bound = 18 * 0x1p-53, sum = u + change;
    if (fabs(sum) <= bound * (fabs(u) + size)) return 0;
    return fabs(change) <= bound * size ? u : sum;
}
/* Slides on with sign s where that excludes every other mode: no other solution is to be looked for. */
static inline int slides_on(int s, double mu, const double *G, const double *c, double *PN, double *PF) {
    double D = G[0] - s * mu * G[1];
    if (s == 0 || !(D > 0)) return 0;
    *PN = -c[0] / D; *PF = -s * mu * *PN;
    return *PN > 0 && s * (c[1] + G[2] * *PN + G[3] * *PF) > 0;
}
/* W has the two rows of the contact, M what has |i - j| <= band; returns whether the step is one of finite numbers. */
static inline int book(int n, int band, double dt, const double *h, const double *M, const double *W, const double *G,
                       const double *c, double gap, double PN, double PF, const double *u, const double *v, Books *b) {
    double P[2] = {PN, PF}, change = 0, force = 0, size = 0, works[2], total = 0, finite = 0 * gap;
    for (int i = 0; i < n; i++) finite += 0 * (v[i] * v[i]);
    if (finite != 0) return 0;
    for (int i = 0; i < n; i++) {
        double momentum = 0, moved = 0, ubar = 0.5 * (u[i] + v[i]), impulse = dt * h[i];
        int first = i > band ? i - band : 0, last = i + band + 1 < n ? i + band + 1 : n;
        for (int j = first; j < last; j++) {
            momentum += M[i * n + j] * (v[j] - u[j]);
            moved += fabs(M[i * n + j]) * (fabs(u[j]) + fabs(v[j]));
        }
        change += ubar * momentum; force += ubar * impulse;
        size += (fabs(u[i]) + fabs(v[i])) * (moved + fabs(impulse));
    }
    for (int r = 0; r < 2; r++) {
        double velocity = 0, speed = 0;
        for (int j = 0; j < n; j++) {
            double part = W[r * n + j] * 0.5 * (u[j] + v[j]);
            velocity += part; speed += fabs(part);
        }
        works[r] = P[r] * velocity; total += works[r]; size += fabs(P[r]) * speed;
    }
    b->force += force; b->normal += works[0]; b->friction += works[1];
    b->size = larger(b->size, size);
    double error = fabs(change - force - total);
    if (error > b->error * b->size) b->error = error / b->size;
    double left = fabs(c[0] + G[0] * PN + G[1] * PF), sliding = c[1] + G[2] * PN + G[3] * PF;
    int slip = fabs(sliding) <= 1e-12 * (fabs(c[0]) + fabs(c[1])) ? 0 : sliding > 0 ? 1 : -1;
    int mode = PN == 0 ? 0 : slip == 0 ? 1 : 2;
    if (mode == 1) left = larger(left, fabs(sliding));
    if (left > b->residual * larger(fabs(c[0]), fabs(c[1]))) b->residual = left / larger(fabs(c[0]), fabs(c[1]));
    if (mode != b->mode || slip != b->slip) { b->mode = mode; b->slip = slip; b->events++; }
    b->penetration = larger(b->penetration, -gap);
    b->P[0] += PN; b->P[1] += PF;
    return 1;
}
