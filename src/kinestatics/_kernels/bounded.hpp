// One period of a control loop as a program with bounds: min |J x - twist|^2 + damping^2 |x|^2, lower <= x <= upper. The
// law of the bounds is that of inverse_velocity/limits.py, in arrays that stay where they are.
#pragma once
#include <cmath>
#include <cstddef>

namespace kinestatics {

// What stays: weights of the six rows (0: not in play), squared damping, period; position limits, greatest speeds and
// greatest accelerations (infinite: any change of rate is allowed) of n joints.
struct BoundedSettings {
  static constexpr size_t size(int n) { return 8 + 4 * (size_t)n; }
  const double *weights, *lower, *upper, *fastest, *acceleration;
  double squared_damping, dt;
  BoundedSettings(const double *from, int n)
      : weights(from), lower(from + 8), upper(lower + n), fastest(upper + n), acceleration(fastest + n),
        squared_damping(from[6]), dt(from[7]) {}
};
// What changes: the weighted rows J (6, n), twist (6), the rates of the period before, H (n, n), f, upper and lower bounds.
struct BoundedProgram {
  static constexpr size_t size(int n) { return 6 + 10 * (size_t)n + (size_t)n * n; }
  double *J, *target, *previous, *H, *f, *upper, *lower;
  BoundedProgram(double *at, int n)
      : J(at), target(J + 6 * n), previous(target + 6), H(previous + n), f(H + n * n), upper(f + n), lower(upper + n) {}
};

inline double approach_rate(double distance, double dt, double acceleration) {
  const double ahead = distance > 0 ? distance : 0;
  if (std::isinf(acceleration)) return ahead / dt;
  const double rate = std::sqrt(2 * acceleration * ahead) - 0.5 * dt * acceleration;
  return rate > 0 ? rate : 0;
}
inline double clipped(double x, double least, double most) { return x < least ? least : x > most ? most : x; }

inline void write_bounds(const BoundedSettings &s, int n, const double *q, BoundedProgram &p) {
  for (int i = 0; i < n; i++) {
    const double most = s.fastest[i], a = s.acceleration[i];
    double up = approach_rate(s.upper[i] - q[i], s.dt, a), down = -approach_rate(q[i] - s.lower[i], s.dt, a);
    up = up < most ? up : most, down = down > -most ? down : -most;
    if (!std::isinf(a)) {  // it holds before the others
      const double held = p.previous[i], change = a * s.dt;
      up = clipped(up, held - change, held + change), down = clipped(down, held - change, held + change);
    }
    p.upper[i] = up, p.lower[i] = down;
  }
}
// Rows that are not in play, or whose component of the twist is NaN, become zero. False for an infinite component.
inline bool weigh_rows(const BoundedSettings &s, int n, const double *twist, BoundedProgram &p) {
  for (int r = 0; r < 6; r++) {
    const bool free = s.weights[r] == 0 || std::isnan(twist[r]);
    if (std::isinf(twist[r])) return false;
    p.target[r] = free ? 0 : s.weights[r] * twist[r];
    for (int i = 0; i < n; i++) p.J[r * n + i] = free ? 0 : p.J[r * n + i] * s.weights[r];
  }
  return true;
}
inline void write_squares(const BoundedSettings &s, int n, BoundedProgram &p) {
  for (int i = 0; i < n; i++) {
    double *__restrict row = p.H + i * n;
    for (int k = 0; k < n; k++) row[k] = 0;
    double slope = 0;
    for (int r = 0; r < 6; r++) {
      const double *J = p.J + r * n;
      const double a = J[i];
      for (int k = 0; k < n; k++) row[k] += a * J[k];
      slope -= a * p.target[r];
    }
    row[i] += s.squared_damping, p.f[i] = slope;
  }
}

}  // namespace kinestatics
