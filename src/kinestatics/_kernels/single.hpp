// The Jacobian of one configuration: 4-lane vectors hold the columns of the rotation, one vector sine serves LANES joints.
// The same operations in the same order as in chain.hpp, so that one call and a batch give the same bits.
#pragma once
#include "chain.hpp"

namespace {

typedef double V4 __attribute__((vector_size(32)));
#if LANES > 2
KS_INLINE V4 fma4(V4 a, V4 b, V4 c) { return (V4)_mm256_fmadd_pd((__m256d)a, (__m256d)b, (__m256d)c); }
KS_INLINE V4 fnma4(V4 a, V4 b, V4 c) { return (V4)_mm256_fnmadd_pd((__m256d)a, (__m256d)b, (__m256d)c); }
#elif defined(__aarch64__)
KS_INLINE V4 fma4(V4 a, V4 b, V4 c) {
  for (int i = 0; i < 4; i++) c[i] = __builtin_fma(a[i], b[i], c[i]);
  return c;
}
KS_INLINE V4 fnma4(V4 a, V4 b, V4 c) { return fma4(-a, b, c); }
#else
KS_INLINE V4 fma4(V4 a, V4 b, V4 c) { return a * b + c; }
KS_INLINE V4 fnma4(V4 a, V4 b, V4 c) { return c - a * b; }
#endif
KS_INLINE V4 all4(double x) { return x - V4{}; }
#define KS_PERMUTE(a, x, y, z) __builtin_shufflevector(a, a, x, y, z, 3)
KS_INLINE V4 cross4(V4 a, V4 b) {
  const V4 ab = KS_PERMUTE(a, 1, 2, 0) * KS_PERMUTE(b, 2, 0, 1);
  return fnma4(KS_PERMUTE(a, 2, 0, 1), KS_PERMUTE(b, 1, 2, 0), ab);
}
struct Frame4 {
  V4 X, Y, Z, p;
};
KS_INLINE void step_fixed(const Joint &j, Frame4 &f) {
  if (j.shift_mask & 1) f.p = fma4(all4(j.p[0]), f.X, f.p);
  if (j.shift_mask & 2) f.p = fma4(all4(j.p[1]), f.Y, f.p);
  if (j.shift_mask & 4) f.p = fma4(all4(j.p[2]), f.Z, f.p);
  const V4 Y = f.Y, Z = f.Z;
  if (j.turn == kinestatics::TURN_PLUS_90) f.Y = Z, f.Z = -Y;
  else if (j.turn == kinestatics::TURN_MINUS_90) f.Y = -Z, f.Z = Y;
  else if (j.turn == kinestatics::TURN_GENERAL)
    f.Y = fma4(all4(j.sa), Z, Y * j.ca), f.Z = fma4(all4(-j.sa), Y, Z * j.ca);
}
KS_INLINE void sines_one(const Program &c, const double *q, double *sine, double *cosine) {
  double angle[LANES];
  for (int i = 0; i < c.joints; i += LANES) {
    VInt quarter{};
    for (int k = 0; k < LANES; k++) {
      const Joint &j = c.joint[i + k < c.joints ? i + k : i];
      angle[k] = j.kind == kinestatics::PRISMATIC ? 0.0 : angle_of(j, broadcast(q[j.column]))[0];
      quarter[k] = j.quarter;
    }
    V s, co;
    const V x = load(angle);
    sincos_small(x, quarter, s, co);
    store(sine + i, s), store(cosine + i, co);
    const bool large = any(is_large(x));
    for (int k = 0; k < LANES && i + k < c.joints; k++) {
      const Joint &j = c.joint[i + k];
      if (j.kind == kinestatics::PRISMATIC) sine[i + k] = j.sine, cosine[i + k] = j.cosine;
      else if (__builtin_expect(large, 0)) {
        double from[LANES], sl[LANES], cl[LANES];
        for (int w = 0; w < LANES; w++) from[w] = angle[k], sl[w] = sine[i + k], cl[w] = cosine[i + k];
        sincos_large(from, j.quarter, sl, cl);
        sine[i + k] = sl[0], cosine[i + k] = cl[0];
      }
    }
  }
}
KS_INLINE void store_column(double *out, int stride, const Joint &j, V4 v, V4 w) {
  double *e = out + j.column;
  if (__builtin_expect(j.add, 0)) {
    for (int r = 0; r < 3; r++) e[r * stride] += v[r], e[(3 + r) * stride] += w[r];
  } else {
    for (int r = 0; r < 3; r++) e[r * stride] = v[r], e[(3 + r) * stride] = w[r];
  }
}
static void k_jacobian_one(const Program *cp, const double *q, double *out, double *scratch) {
  const Program &c = *cp;
  const int n = c.joints;
  double *sine = scratch, *cosine = scratch + round_up(n);
  V4 *axis = (V4 *)(scratch + 2 * round_up(n)), *origin = axis + n;
  if (!c.all_columns) std::memset(out, 0, sizeof(double) * 6 * c.columns);
  if (n == 0) return;
  sines_one(c, q, sine, cosine);
  const double *m = c.joint[0].matrix, *t = c.joint[0].p;
  Frame4 f = {{m[0], m[3], m[6], 0}, {m[1], m[4], m[7], 0}, {m[2], m[5], m[8], 0}, {t[0], t[1], t[2], 0}};
  for (int i = 0; i < n; i++) {
    const Joint &j = c.joint[i];
    if (i) step_fixed(j, f);
    const V4 X = f.X, Y = f.Y, s = all4(sine[i]), co = all4(cosine[i]);
    f.X = fma4(s, Y, co * X);
    f.Y = fnma4(s, X, co * Y);
    if (j.kind != kinestatics::REVOLUTE) {
      const V advance = fma_(j.lift, broadcast(q[j.column]), broadcast(j.lift0));
      f.p = fma4(all4(advance[0]), f.Z, f.p);
    }
    axis[i] = f.Z, origin[i] = f.p;
  }
  V4 at = f.p;
  for (int k = 0; k < 3; k++)
    if (c.tail_position[k] != 0) at = fma4(all4(c.tail_position[k]), k == 0 ? f.X : k == 1 ? f.Y : f.Z, at);
  if (c.origin_at_base) at = V4{};
  for (int i = 0; i < n; i++) {
    const Joint &j = c.joint[i];
    V4 v, w;
    if (j.kind == kinestatics::PRISMATIC) {
      v = axis[i] * j.lift, w = axis[i] * 0.0;
    } else {
      v = cross4(axis[i], at - origin[i]), w = axis[i];
      if (j.scale != 1.0) v = v * j.scale, w = w * j.scale;
      if (j.kind == kinestatics::HELICAL) v = fma4(all4(j.lift), axis[i], v);
    }
    store_column(out, c.columns, j, v, w);
  }
}

}  // namespace
