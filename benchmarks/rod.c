/* The sliding rod's Moreau-Jean step with everything known to the compiler: the floor. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
int main(int argc, char **argv) {
    long n = atol(argv[1]);
    double dt = 0.3 / n, m = 1, s = 1, I = 1.0 / 3, g = 9.81, mu = 0.5;
    double th0 = acos(-1.0) / 3, q[3] = {0, sin(th0), th0}, u[3] = {1, 0, 0};
    struct timespec a, b;
    clock_gettime(CLOCK_MONOTONIC, &a);
    for (long k = 0; k < n; k++) {
        double x = q[0] + dt / 2 * u[0], y = q[1] + dt / 2 * u[1], th = q[2] + dt / 2 * u[2], e = q[2] + dt * u[2];
        double gN = y - s * sin(th), f[3] = {u[0], u[1] - g * dt, u[2]};
        double N2 = -s * cos(th), T2 = s * sin(th), dN = -s * cos(e) - N2, dT = s * sin(e) - T2;
        gN -= dt / 4 * dN * u[2];
        double GNN = 1 / m + N2 * N2 / I, GTT = 1 / m + T2 * T2 / I, GNT = N2 * T2 / I;
        double cN = f[1] + N2 * f[2] + dN * u[2] + (gN > 0 ? gN / dt : 0), cT = f[0] + T2 * f[2] + dT * u[2];
        double PN = 0, PT = 0;
        if (cN < 0) {
            double det = GNN * GTT - GNT * GNT;
            PN = (GNT * cT - GTT * cN) / det;
            PT = (GNT * cN - GNN * cT) / det;
            if (!(PN >= 0 && fabs(PT) <= mu * PN)) {
                double sign = cT - GNT * cN / GNN > 0 ? 1 : -1;
                PN = -cN / (GNN - sign * mu * GNT);
                PT = -sign * mu * PN;
            }
        }
        double v[3] = {f[0] + PT / m, f[1] + PN / m, f[2] + (N2 * PN + T2 * PT) / I};
        for (int i = 0; i < 3; i++) { q[i] += dt / 2 * (u[i] + v[i]); u[i] = v[i]; }
        (void)x;
    }
    clock_gettime(CLOCK_MONOTONIC, &b);
    printf("%.17g %.17g\n", ((b.tv_sec - a.tv_sec) * 1e9 + (b.tv_nsec - a.tv_nsec)) / n, q[2]);
    return 0;
}
