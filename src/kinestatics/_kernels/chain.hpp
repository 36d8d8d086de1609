// The forward pass and the columns of the Jacobian for LANES configurations at once. The running frame stays in registers.
#pragma once
#include "program.hpp"
#include "rows.hpp"

namespace {  // every instruction set has its own copy: nothing here may be shared by the linker


using kinestatics::Joint;
using kinestatics::Program;

struct Vec {
  V x, y, z;
};
KS_INLINE Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
KS_INLINE Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
KS_INLINE Vec operator*(V s, Vec a) { return {s * a.x, s * a.y, s * a.z}; }
KS_INLINE Vec add_scaled(Vec a, V s, Vec b) { return {fma_(s, b.x, a.x), fma_(s, b.y, a.y), fma_(s, b.z, a.z)}; }
KS_INLINE Vec add_scaled(Vec a, double s, Vec b) { return add_scaled(a, broadcast(s), b); }
KS_INLINE Vec cross(Vec a, Vec b) {
  return {fnma_(a.z, b.y, a.y * b.z), fnma_(a.x, b.z, a.z * b.x), fnma_(a.y, b.x, a.x * b.y)};
}
KS_INLINE V dot(Vec a, Vec b) { return fma_(a.z, b.z, fma_(a.y, b.y, a.x * b.x)); }
KS_INLINE Vec scaled(Vec a, double s) { return broadcast(s) * a; }

// Axes and origin of a frame in base axes; X, Y, Z are the columns of its rotation.
struct Frame {
  Vec X, Y, Z, p;
};
KS_INLINE Frame base_frame() {
  const V one = broadcast(1), zero = broadcast(0);
  return {{one, zero, zero}, {zero, one, zero}, {zero, zero, one}, {zero, zero, zero}};
}
KS_INLINE void turn_by_matrix(const double *m, Frame &f) {
  const Vec X = f.X, Y = f.Y, Z = f.Z;
  f.X = add_scaled(add_scaled(scaled(X, m[0]), m[3], Y), m[6], Z);
  f.Y = add_scaled(add_scaled(scaled(X, m[1]), m[4], Y), m[7], Z);
  f.Z = add_scaled(add_scaled(scaled(X, m[2]), m[5], Y), m[8], Z);
}
// The fixed part of a joint.
KS_INLINE void step_fixed(const Joint &j, Frame &f) {
  if (j.shift_mask & 1) f.p = add_scaled(f.p, j.p[0], f.X);
  if (j.shift_mask & 2) f.p = add_scaled(f.p, j.p[1], f.Y);
  if (j.shift_mask & 4) f.p = add_scaled(f.p, j.p[2], f.Z);
  const Vec Y = f.Y, Z = f.Z;
  switch (j.turn) {
    case kinestatics::TURN_PLUS_90:
      f.Y = Z;
      f.Z = {-Y.x, -Y.y, -Y.z};
      break;
    case kinestatics::TURN_MINUS_90:
      f.Y = {-Z.x, -Z.y, -Z.z};
      f.Z = Y;
      break;
    case kinestatics::TURN_GENERAL:
      f.Y = add_scaled(scaled(Y, j.ca), j.sa, Z);
      f.Z = add_scaled(scaled(Z, j.ca), -j.sa, Y);
      break;
    case kinestatics::TURN_MATRIX:
      turn_by_matrix(j.matrix, f);
      break;
    default:
      break;
  }
}
// The first fixed part: constants of the program, the same in every lane.
KS_INLINE Frame first_frame(const Joint &j) {
  const double *m = j.matrix, *p = j.p;
  return {{broadcast(m[0]), broadcast(m[3]), broadcast(m[6])},
          {broadcast(m[1]), broadcast(m[4]), broadcast(m[7])},
          {broadcast(m[2]), broadcast(m[5]), broadcast(m[8])},
          {broadcast(p[0]), broadcast(p[1]), broadcast(p[2])}};
}
// The moving part: sine and cosine were computed before; q is the joint's entry.
KS_INLINE void step_moving(const Joint &j, V sine, V cosine, V q, Frame &f) {
  const Vec X = f.X, Y = f.Y;
  f.X = add_scaled(cosine * X, sine, Y);
  f.Y = {fnma_(sine, X.x, cosine * Y.x), fnma_(sine, X.y, cosine * Y.y), fnma_(sine, X.z, cosine * Y.z)};
  if (j.kind != kinestatics::REVOLUTE) f.p = add_scaled(f.p, fma_(j.lift, q, broadcast(j.lift0)), f.Z);
}
KS_INLINE V angle_of(const Joint &j, V q) { return fma_(j.scale, q, broadcast(j.offset)); }

// What a block of LANES configurations knows of one joint; v and w are free for each quantity's own use.
struct State {
  V sine, cosine;
  Vec axis, origin, v, w;
};
// Scratch arrays of one block, carved from one aligned buffer.
struct Block {
  V *entries;  // rows on their way out
  V *q, *second, *result;
  State *at;
};
static inline size_t round_up(size_t n) { return (n + LANES - 1) / LANES * LANES; }
// Room for the rows of a block: the Hessian's, or for all else two Jacobians or a pose.
static inline size_t entries_size(const Program &c, bool hessian) {
  const size_t n = c.columns, needed = hessian ? 6 * n * n : 12 * n;
  return round_up(needed > 16 ? needed : 16) + LANES;
}
static inline size_t per_joint(const Program &c) { return round_up(c.joints > c.columns ? c.joints : c.columns) + LANES; }
static constexpr size_t STATE_SIZE = sizeof(State) / sizeof(V);
static inline size_t block_size(const Program &c, bool hessian) {
  return (entries_size(c, hessian) + (3 + STATE_SIZE) * per_joint(c)) * LANES;
}
KS_INLINE Block carve(const Program &c, double *scratch) {
  const size_t n = per_joint(c);
  V *at = (V *)scratch;
  Block b;
  b.q = at, b.second = at + n, b.result = at + 2 * n;
  b.at = (State *)(at + 3 * n);
  b.entries = at + (3 + STATE_SIZE) * n;
  return b;
}

template <int M>
KS_INLINE void some_sines(const Joint *joint, const V *q, State *at, VInt &large) {
  V x[M], rounder[M], sine[M], cosine[M];
  KS_UNROLL
  for (int m = 0; m < M; m++) {
    const Joint &j = joint[m];
    x[m] = j.kind == kinestatics::PRISMATIC ? broadcast(0) : angle_of(j, q[j.column]);
    rounder[m] = broadcast(j.rounder);
    large |= is_large(x[m]);
  }
  sincos_small<M>(x, rounder, sine, cosine);
  KS_UNROLL
  for (int m = 0; m < M; m++) {
    const Joint &j = joint[m];
    if (j.kind == kinestatics::PRISMATIC) at[m].sine = broadcast(j.sine), at[m].cosine = broadcast(j.cosine);
    else at[m].sine = sine[m], at[m].cosine = cosine[m];
  }
}
KS_INLINE void all_sines(const Program &c, const V *q, State *at) {
  VInt large{};
  int i = 0;
  for (; i + 3 <= c.joints; i += 3) some_sines<3>(c.joint + i, q, at + i, large);
  for (; i < c.joints; i++) some_sines<1>(c.joint + i, q, at + i, large);
  if (__builtin_expect(any(large), 0))
    for (i = 0; i < c.joints; i++)
      if (c.joint[i].kind != kinestatics::PRISMATIC)
        sincos(angle_of(c.joint[i], q[c.joint[i].column]), c.joint[i].quarter, at[i].sine, at[i].cosine);
}
// From q (by column) to the frame behind the last joint of a chain; keeps the axis and origin of every joint on the way.
template <bool KEEP = true>
KS_INLINE Frame forward(const Program &c, const V *q, Block &b) {
  if (c.joints == 0) return base_frame();
  all_sines(c, q, b.at);
  Frame f = first_frame(c.joint[0]);
  for (int i = 0; i < c.joints; i++) {
    const Joint &j = c.joint[i];
    if (i) step_fixed(j, f);
    step_moving(j, b.at[i].sine, b.at[i].cosine, q[j.column], f);
    if (KEEP) b.at[i].axis = f.Z, b.at[i].origin = f.p;
  }
  return f;
}
KS_INLINE Vec tail_point(const Program &c, const Frame &f) {
  const double *t = c.tail_position;
  Vec p = f.p;
  if (t[0] != 0) p = add_scaled(p, t[0], f.X);
  if (t[1] != 0) p = add_scaled(p, t[1], f.Y);
  if (t[2] != 0) p = add_scaled(p, t[2], f.Z);
  return p;
}
KS_INLINE Frame tail(const Program &c, Frame f) {
  f.p = tail_point(c, f);
  turn_by_matrix(c.tail_rotation, f);
  return f;
}
KS_INLINE Vec into_axes(const Frame &f, Vec a) { return {dot(f.X, a), dot(f.Y, a), dot(f.Z, a)}; }

// Twist per unit rate of a joint's own coordinate, base axes, at the point `at` (scale included).
KS_INLINE void twist_of(const Joint &j, Vec axis, Vec origin, Vec at, Vec &v, Vec &w) {
  if (j.plain) {
    v = cross(axis, at - origin), w = axis;
    return;
  }
  if (j.kind == kinestatics::PRISMATIC) {
    v = scaled(axis, j.lift);
    w = scaled(axis, 0);
    return;
  }
  v = cross(axis, at - origin);
  w = axis;
  if (j.scale != 1.0) v = scaled(v, j.scale), w = scaled(w, j.scale);
  if (j.kind == kinestatics::HELICAL) v = add_scaled(v, j.lift, axis);
}
// Into entries[row * stride + column]; joints that share a column (mimic) are added up.
KS_INLINE void store_three(V *e, ptrdiff_t stride, Vec a) { e[0] = a.x, e[stride] = a.y, e[2 * stride] = a.z; }
KS_INLINE void put(V *entries, ptrdiff_t stride, const Joint &j, Vec v, Vec w) {
  V *linear = entries + j.column, *angular = linear + 3 * stride;
  if (__builtin_expect(j.add, 0)) {
    linear[0] += v.x, linear[stride] += v.y, linear[2 * stride] += v.z;
    angular[0] += w.x, angular[stride] += w.y, angular[2 * stride] += w.z;
    return;
  }
  store_three(linear, stride, v);
  store_three(angular, stride, w);
}
KS_INLINE void jacobian_block(const Program &c, const V *q, Block &b) {
  const Frame f = forward(c, q, b);
  const V zero = broadcast(0);
  const Vec at = c.origin_at_base ? Vec{zero, zero, zero} : tail_point(c, f);
  if (!c.axes_of_target) {
    for (int i = 0; i < c.joints; i++) {
      const Joint &j = c.joint[i];
      const Vec axis = b.at[i].axis, arm = at - b.at[i].origin;
      if (__builtin_expect(j.plain, 1)) {
        V *linear = b.entries + j.column, *angular = linear + 3 * (ptrdiff_t)c.columns;
        store_three(linear, c.columns, cross(axis, arm));
        store_three(angular, c.columns, axis);
        continue;
      }
      Vec v, w;
      twist_of(j, axis, b.at[i].origin, at, v, w);
      put(b.entries, c.columns, j, v, w);
    }
    return;
  }
  const Frame t = tail(c, f);
  for (int i = 0; i < c.joints; i++) {
    Vec v, w;
    twist_of(c.joint[i], b.at[i].axis, b.at[i].origin, at, v, w);
    put(b.entries, c.columns, c.joint[i], into_axes(t, v), into_axes(t, w));
  }
}

}  // namespace
