/* Gaps, rows, masses and forces that Siconos takes from a compiled plugin; rows are stored by columns.
   The parameters of the models are macros: cc -Dm=1.0 -Dl=2.0 ... */
#include <math.h>

typedef unsigned int size;

/* One contact of a rod: its tip, half a length below the centre; q = (x, y, th). */
#ifdef ROD
void tip_gap(size n, const double *q, size n_y, double *y, size n_z, double *z) {
  y[0] = q[1] - l / 2 * sin(q[2]);
}
void tip_rows(size n, const double *q, size n_y, double *G, size n_z, double *z) {
  G[0] = 0.0, G[2] = 1.0, G[4] = -l / 2 * cos(q[2]);
  G[1] = 1.0, G[3] = 0.0, G[5] = l / 2 * sin(q[2]);
}
#endif

/* Two corners of a block; q = (x, y, th). */
#ifdef BLOCK
static void corner_gap(double side, const double *q, double *y) {
  y[0] = q[1] + side * width / 2 * sin(q[2]) - height / 2 * cos(q[2]);
}
static void corner_rows(double side, const double *q, double *G) {
  double a = side * width / 2, b = height / 2, s = sin(q[2]), c = cos(q[2]);
  G[0] = 0.0, G[2] = 1.0, G[4] = a * c + b * s;
  G[1] = 1.0, G[3] = 0.0, G[5] = -a * s + b * c;
}
void left_gap(size n, const double *q, size n_y, double *y, size n_z, double *z) { corner_gap(-1.0, q, y); }
void left_rows(size n, const double *q, size n_y, double *G, size n_z, double *z) { corner_rows(-1.0, q, G); }
void right_gap(size n, const double *q, size n_y, double *y, size n_z, double *z) { corner_gap(1.0, q, y); }
void right_rows(size n, const double *q, size n_y, double *G, size n_z, double *z) { corner_rows(1.0, q, G); }
#endif

/* A pendulum and a wall; q = (th). */
#ifdef PENDULUM
void wall_gap(size n, const double *q, size n_y, double *y, size n_z, double *z) { y[0] = l * (sin(q[0]) - sin(th_w)); }
void wall_rows(size n, const double *q, size n_y, double *G, size n_z, double *z) { G[0] = l * cos(q[0]); }
void inner_force(double t, size n, const double *q, const double *u, double *f, size n_z, double *z) {
  f[0] = m * g * l * sin(q[0]);
}
#endif

/* Slider-crank with clearance; q = (th1, th2, th3). */
#ifdef SLIDER_CRANK
void mass(size n, const double *q, double *M, size n_z, double *z) {
  for (int k = 0; k < 9; k++) M[k] = 0.0;
  M[0] = J1 + l1 * l1 * (m1 / 4 + m2 + m3);
  M[1] = M[3] = l1 * l2 * (m2 / 2 + m3) * cos(q[0] - q[1]);
  M[4] = J2 + l2 * l2 * (m2 / 4 + m3);
  M[8] = J3;
}
void inner_force(double t, size n, const double *q, const double *u, double *f, size n_z, double *z) {
  double B = l1 * l2 * (m2 / 2 + m3) * sin(q[0] - q[1]);
  f[0] = B * u[1] * u[1] + g * l1 * (m1 / 2 + m2 + m3) * cos(q[0]);
  f[1] = -B * u[0] * u[0] + g * l2 * (m2 / 2 + m3) * cos(q[1]);
  f[2] = 0.0;
}
static void slider_gap(double i, double j, const double *q, double *y) {
  y[0] = b + c - j * (l1 * sin(q[0]) + l2 * sin(q[1]) + i * a * sin(q[2])) - b * cos(q[2]);
}
static void slider_rows(double i, double j, const double *q, double *G) {
  double sine = sin(q[2]), cosine = cos(q[2]);
  G[0] = -j * l1 * cos(q[0]), G[2] = -j * l2 * cos(q[1]), G[4] = -i * j * a * cosine + b * sine;
  G[1] = -l1 * sin(q[0]), G[3] = -l2 * sin(q[1]), G[5] = -i * a * sine - j * b * cosine;
}
#define CORNER(name, i, j)                                                                                            \
  void name##_gap(size n, const double *q, size n_y, double *y, size n_z, double *z) { slider_gap(i, j, q, y); }      \
  void name##_rows(size n, const double *q, size n_y, double *G, size n_z, double *z) { slider_rows(i, j, q, G); }
CORNER(upper_left, -1.0, 1.0)
CORNER(upper_right, 1.0, 1.0)
CORNER(lower_left, -1.0, -1.0)
CORNER(lower_right, 1.0, -1.0)
#endif

/* A mass on a belt; q = (x, y). A weight N in y makes the normal force, and the contact has the friction m0. The rest
   of it, -m1 v + m3 v^3 with v = vb - x', is odd and smooth, and so a force like that of a damper. */
#ifdef BELT
void inner_force(double t, size n, const double *q, const double *u, double *f, size n_z, double *z) {
  double v = vb - u[0];
  f[0] = k * q[0] + c * u[0] - N * v * (-m1 + m3 * v * v);
  f[1] = N;
}
void stiffness(double t, size n, const double *q, const double *u, double *K, size n_z, double *z) {
  K[0] = k, K[1] = K[2] = K[3] = 0.0;
}
void damping(double t, size n, const double *q, const double *u, double *C, size n_z, double *z) {
  double v = vb - u[0];
  C[0] = c + N * (-m1 + 3 * m3 * v * v), C[1] = C[2] = C[3] = 0.0;
}
void belt_gap(size n, const double *q, double t, size n_y, double *y, size n_z, double *z) {
  y[0] = q[1], y[1] = q[0] - vb * t;
}
void belt_rows(size n, const double *q, double t, size n_y, double *G, size n_z, double *z) {
  G[0] = G[3] = 0.0, G[1] = G[2] = 1.0;
}
void belt_rates(size n, const double *q, double t, size n_y, double *rate, size n_z, double *z) {
  rate[0] = 0.0, rate[1] = -vb;
}
#endif

/* Sprag-slip; q = (g, th), g = y - l sin th. Two contacts of opposite sides with a play stand for a bilateral one. */
#ifdef SPRAG_SLIP
void mass(size n, const double *q, double *M, size n_z, double *z) {
  double arm = l * cos(q[1]);
  M[0] = m, M[1] = M[2] = m * arm, M[3] = I + m * arm * arm;
}
void inner_force(double t, size n, const double *q, const double *u, double *f, size n_z, double *z) {
  double arm = l * cos(q[1]), height = l * sin(q[1]);
  f[0] = cy * (u[0] + arm * u[1]) + ky * (q[0] + height) + R - m * height * u[1] * u[1];
  f[1] = cth * u[1] + kth * (q[1] - th0) - R * arm + arm * f[0];
}
static void side_rows(double side, const double *q, double *G) { G[0] = side, G[1] = G[2] = 0.0, G[3] = l * sin(q[1]); }
void above_gap(size n, const double *q, double t, size n_y, double *y, size n_z, double *z) {
  y[0] = q[0] + play / 2, y[1] = -l * cos(q[1]) - vb * t;
}
void below_gap(size n, const double *q, double t, size n_y, double *y, size n_z, double *z) {
  y[0] = play / 2 - q[0], y[1] = -l * cos(q[1]) - vb * t;
}
void above_rows(size n, const double *q, double t, size n_y, double *G, size n_z, double *z) { side_rows(1.0, q, G); }
void below_rows(size n, const double *q, double t, size n_y, double *G, size n_z, double *z) { side_rows(-1.0, q, G); }
void belt_rates(size n, const double *q, double t, size n_y, double *rate, size n_z, double *z) {
  rate[0] = 0.0, rate[1] = -vb;
}
#endif
