/* The same step for any model behind function pointers, its mass matrix factored at every step. */
#include "rod_books.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
typedef struct { double m, l, I, g, mu; } P;
typedef void (*Fn)(double t, const double *q, const double *u, const double *p, double *out);
static void mass(double t, const double *q, const double *u, const double *a, double *M) {
    const P *p = (const P *)a; M[0] = p->m; M[4] = p->m; M[8] = p->I; }
static void force(double t, const double *q, const double *u, const double *a, double *h) {
    const P *p = (const P *)a; h[1] = -p->m * p->g; }
static void gap(double t, const double *q, const double *u, const double *a, double *g) {
    const P *p = (const P *)a; g[0] = q[1] - p->l / 2 * sin(q[2]); }
static void normal(double t, const double *q, const double *u, const double *a, double *W) {
    const P *p = (const P *)a; W[1] = 1; W[2] = -p->l / 2 * cos(q[2]); }
static void tangent(double t, const double *q, const double *u, const double *a, double *W) {
    const P *p = (const P *)a; W[0] = 1; W[2] = p->l / 2 * sin(q[2]); }
typedef struct { Fn mass, force, gap, normal, tangent; int n; const double *p; double mu; } Model;
static int cholesky(int n, const double *A, double *L) {
    for (int i = 0; i < n; i++)
        for (int j = 0; j <= i; j++) {
            double s = A[i * n + j];
            for (int k = 0; k < j; k++) s -= L[i * n + k] * L[j * n + k];
            if (i == j) { if (!(s > 0)) return 0; L[i * n + i] = 1 / sqrt(s); } else L[i * n + j] = s * L[j * n + j];
        }
    return 1;
}
static void solve(int n, const double *L, double *x) {
    for (int i = 0; i < n; i++) { double s = x[i]; for (int k = 0; k < i; k++) s -= L[i * n + k] * x[k]; x[i] = s * L[i * n + i]; }
    for (int i = n - 1; i >= 0; i--) { double s = x[i]; for (int k = i + 1; k < n; k++) s -= L[k * n + i] * x[k]; x[i] = s * L[i * n + i]; }
}
static double dot(int n, const double *a, const double *b) { double s = 0; for (int i = 0; i < n; i++) s += a[i] * b[i]; return s; }
int main(int argc, char **argv) {
    long steps = atol(argv[1]);
    double p[] = {1, 2, 1.0 / 3, 9.81, 0.5};
    Model model = {mass, force, gap, normal, tangent, 3 + 0 * argc, p, 0.5};
    volatile Model *hidden = &model; Model m = *hidden; int n = m.n;
    double *w = calloc(20 * n * n + 20 * n, 8), *q = w, *u = q + n, *mid = u + n, *end = mid + n, *h = end + n, *v = h + n;
    double *W = v + n, *E = W + 2 * n, *X = E + 2 * n, *M = X + 2 * n, *L = M + n * n, *u1 = L + n * n, g[1];
    double dt = 0.3 / steps, th0 = acos(-1.0) / 3; q[1] = sin(th0); q[2] = th0; u[0] = 1;
    Books books = {.mode = 2, .slip = 1};
#ifdef BOOKS
    int band = 0 * argc; /* of M, which is diagonal; the compiler is not told */
#endif
    struct timespec a, b; clock_gettime(CLOCK_MONOTONIC, &a);
    for (long k = 0; k < steps; k++) {
        double t = k * dt;
        for (int i = 0; i < n; i++) { mid[i] = q[i] + dt / 2 * u[i]; end[i] = q[i] + dt * u[i]; }
        m.gap(t + dt / 2, mid, u, p, g);
        m.mass(t + dt / 2, mid, u, p, M);
        if (!cholesky(n, M, L)) return 1;
        m.force(t + dt / 2, mid, u, p, h);
        for (int i = 0; i < n; i++) v[i] = dt * h[i];
        solve(n, L, v);
        m.normal(t + dt / 2, mid, u, p, W); m.tangent(t + dt / 2, mid, u, p, W + n);
        m.normal(t + dt, end, u, p, E); m.tangent(t + dt, end, u, p, E + n);
        double G[4], c[2];
        for (int r = 0; r < 2; r++) { memcpy(X + r * n, W + r * n, n * 8); solve(n, L, X + r * n); }
        for (int r = 0; r < 2; r++) {
            for (int s = 0; s < 2; s++) G[2 * r + s] = dot(n, W + r * n, X + s * n);
            c[r] = dot(n, E + r * n, u) + dot(n, W + r * n, v);
        }
        g[0] -= dt / 4 * (dot(n, E, u) - dot(n, W, u));
        if (g[0] > 0) c[0] += g[0] / dt;
        double PN = 0, PT = 0;
#ifdef BOOKS
        if (c[0] < 0 && !slides_on(books.slip, m.mu, G, c, &PN, &PT)) {
#else
        if (c[0] < 0) {
#endif
            double det = G[0] * G[3] - G[1] * G[2];
            PN = (G[1] * c[1] - G[3] * c[0]) / det; PT = (G[2] * c[0] - G[0] * c[1]) / det;
            if (!(PN >= 0 && fabs(PT) <= m.mu * PN)) {
                double sign = c[1] - G[1] * c[0] / G[0] > 0 ? 1 : -1;
                PN = -c[0] / (G[0] - sign * m.mu * G[1]); PT = -sign * m.mu * PN;
            }
        }
#ifdef BOOKS
        for (int i = 0; i < n; i++) {
            double N = X[i] * PN, T = X[n + i] * PT;
            u1[i] = rounded(u[i], v[i] + N + T, fabs(v[i]) + fabs(N) + fabs(T));
        }
        if (!book(n, band, dt, h, M, W, G, c, g[0], PN, PT, u, u1, &books)) return 1;
#else
        for (int i = 0; i < n; i++) u1[i] = u[i] + v[i] + X[i] * PN + X[n + i] * PT;
#endif
        for (int i = 0; i < n; i++) { q[i] += dt / 2 * (u[i] + u1[i]); u[i] = u1[i]; }
    }
    clock_gettime(CLOCK_MONOTONIC, &b);
    printf("%.17g %.17g %.17g\n", ((b.tv_sec - a.tv_sec) * 1e9 + (b.tv_nsec - a.tv_nsec)) / steps, q[2], books.friction);
}
