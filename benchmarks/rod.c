/* The sliding rod's Moreau-Jean step with everything known to the compiler: the floor. */
#include "rod_books.h"
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
int main(int argc, char **argv) {
    long n = atol(argv[1]);
    double dt = 0.3 / n, m = 1, s = 1, I = 1.0 / 3, g = 9.81, mu = 0.5;
    double th0 = acos(-1.0) / 3, q[3] = {0, sin(th0), th0}, u[3] = {1, 0, 0};
    struct timespec a, b;
    Books books = {.mode = 2, .slip = 1};
    clock_gettime(CLOCK_MONOTONIC, &a);
    for (long k = 0; k < n; k++) {
        double x = q[0] + dt / 2 * u[0], y = q[1] + dt / 2 * u[1], th = q[2] + dt / 2 * u[2], e = q[2] + dt * u[2];
        double gN = y - s * sin(th), f[3] = {u[0], u[1] - g * dt, u[2]};
        double N2 = -s * cos(th), T2 = s * sin(th), dN = -s * cos(e) - N2, dT = s * sin(e) - T2;
        gN -= dt / 4 * dN * u[2];
        double GNN = 1 / m + N2 * N2 / I, GTT = 1 / m + T2 * T2 / I, GNT = N2 * T2 / I;
        double cN = f[1] + N2 * f[2] + dN * u[2] + (gN > 0 ? gN / dt : 0), cT = f[0] + T2 * f[2] + dT * u[2];
        double PN = 0, PT = 0;
#ifdef BOOKS
        const double W[6] = {0, 1, N2, 1, 0, T2}, M[9] = {m, 0, 0, 0, m, 0, 0, 0, I}, h[3] = {0, -m * g, 0};
        const double G[4] = {GNN, GNT, GNT, GTT}, c[2] = {cN, cT}, d[3] = {0, -g * dt, 0};
        if (cN < 0 && !slides_on(books.slip, mu, G, c, &PN, &PT)) {
#else
        if (cN < 0) {
#endif
            double det = GNN * GTT - GNT * GNT;
            PN = (GNT * cT - GTT * cN) / det;
            PT = (GNT * cN - GNN * cT) / det;
            if (!(PN >= 0 && fabs(PT) <= mu * PN)) {
                double sign = cT - GNT * cN / GNN > 0 ? 1 : -1;
                PN = -cN / (GNN - sign * mu * GNT);
                PT = -sign * mu * PN;
            }
        }
#ifdef BOOKS
        const double X[6] = {0, PN / m, N2 * PN / I, PT / m, 0, T2 * PT / I};
        double v[3];
        for (int i = 0; i < 3; i++)
            v[i] = rounded(u[i], d[i] + X[i] + X[3 + i], fabs(d[i]) + fabs(X[i]) + fabs(X[3 + i]));
        if (!book(3, 0, dt, h, M, W, G, c, gN, PN, PT, u, v, &books)) return 1;
#else
        double v[3] = {f[0] + PT / m, f[1] + PN / m, f[2] + (N2 * PN + T2 * PT) / I};
#endif
        for (int i = 0; i < 3; i++) { q[i] += dt / 2 * (u[i] + v[i]); u[i] = v[i]; }
        (void)x;
    }
    clock_gettime(CLOCK_MONOTONIC, &b);
    printf("%.17g %.17g %.17g\n", ((b.tv_sec - a.tv_sec) * 1e9 + (b.tv_nsec - a.tv_nsec)) / n, q[2], books.friction);
    return 0;
}
