/* The belt oscillator's Moreau-Jean step for LANES belts of different speeds side by side: a structure of arrays, what
   differs from lane to lane in masks. With -DLANES=1 the same source is one belt. Cubic friction, theta = 1/2.

   cc -O3 -march=native -DLANES=8 belt_lanes.c -lm; a.out STEPS DT  prints nanoseconds a step and belt, and x of each. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#ifndef LANES
#define LANES 8
#endif
typedef double V __attribute__((vector_size(8 * LANES)));
typedef long Mask __attribute__((vector_size(8 * LANES)));
static const double m = 1, k = 10, c = 0.1, N = 1, m0 = 0.4, m1 = 0.45, m3 = 0.6;
static int any(Mask a) { long is = 0; for (int i = 0; i < LANES; i++) is |= a[i]; return is != 0; }
static V pick(Mask is, V a, V b) { return (V)(((Mask)a & is) | ((Mask)b & ~is)); }
static V larger(V a, V b) { return pick(a > b, a, b); }
static V size(V a) { return pick(a < 0, -a, a); }
static V law(V v) { return m0 - m1 * v + m3 * v * v * v; }
/* The speed in the middle of a step that the friction at the speed v leads to. */
static V middle(V v, V s, V offset, V cF, double G, double P) { return larger(v * 0, s * (offset + cF - s * law(v) * G * P) / 2); }
/* The speed that leads to itself: Newton within a bracket, until every lane that slides has it. */
static V speed(V s, V offset, V cF, double G, double P, Mask slides) {
    V low = s * 0, high = larger(low, s * (offset + cF) / 2), v = larger(low, s * offset);
    v = pick(v < high, v, high);
    for (int n = 0; n < 60; n++) {
        V excess = v - middle(v, s, offset, cF, G, P);
        Mask open = slides & (size(excess) > 4e-16 * (size(v) + size(offset)));
        if (!any(open)) break;
        high = pick(open & (excess > 0), v, high);
        low = pick(open & (excess <= 0), v, low);
        V step = 1e-7 * v + 1e-12 * size(offset) + 1e-300;
        V slope = (v + step - middle(v + step, s, offset, cF, G, P) - excess) / step;
        V next = pick(slope > 0, v - excess / slope, high);
        next = pick((low < next) & (next < high), next, 0.5 * (low + high));
        v = pick(open, next, v);
        slides = open & (high - low > 4e-16 * high);
    }
    return v;
}
int main(int argc, char **argv) {
    long steps = atol(argv[1]);
    double dt = argc > 2 ? atof(argv[2]) : 1e-3, G = 1 / (m + dt / 2 * c + dt * dt / 4 * k), P = dt * N;
    V x, u, s, vb;
    for (int i = 0; i < LANES; i++) { x[i] = u[i] = 0; vb[i] = 0.1 + 0.05 * i; s[i] = -1; }
    struct timespec a, b;
    clock_gettime(CLOCK_MONOTONIC, &a);
    for (long n = 0; n < steps; n++) {
        V du = dt * G * (-c * u - k * (x + dt / 2 * u)), offset = u - vb, cF = offset + du, none = u * 0;
        V PF = none, slip = none;
        Mask left = ~(Mask){0}, slides = s != 0;
        if (any(slides)) { /* on, where that excludes all else */
            V F = -s * law(speed(s, offset, cF, G, P, slides)) * P;
            Mask on = slides & (s * (cF + G * F) > 0);
            PF = pick(on, F, PF); slip = pick(on, s, slip); left &= ~on;
        }
        if (any(left)) {
            V F = -cF / G;
            Mask sticks = left & (size(F) <= m0 * P);
            PF = pick(sticks, F, PF); left &= ~sticks;
            for (int sign = 1; sign >= -1 && any(left); sign -= 2) {
                V way = none + sign;
                F = -way * law(speed(way, offset, cF, G, P, left)) * P;
                Mask goes = left & (way * (cF + G * F) > 0);
                PF = pick(goes, F, PF); slip = pick(goes, way, slip); left &= ~goes;
            }
        }
        V v = u + du + G * PF;
        x += dt / 2 * (u + v); u = v; s = slip;
    }
    clock_gettime(CLOCK_MONOTONIC, &b);
    printf("%.17g", ((b.tv_sec - a.tv_sec) * 1e9 + (b.tv_nsec - a.tv_nsec)) / steps / LANES);
    for (int i = 0; i < LANES; i++) printf(" %.17g", x[i]);
    printf("\n");
}
