// The Jacobian of one configuration: 4-lane vectors hold the columns of the rotation, and vector sines serve LANES joints each.
// The same operations in the same order as in chain.hpp, so that one call and a batch give the same bits.
#pragma once
#include "chain.hpp"

namespace {

typedef double V4 __attribute__((vector_size(32)));
typedef long long V4Int __attribute__((vector_size(32)));
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
#define KS_PERMUTE(a, x, y, z) KS_SHUFFLE(V4Int, a, a, x, y, z, 3)
KS_INLINE V4 cross4(V4 a, V4 b) {  // z, x, y first: three permutations instead of four, the roundings of Vec's cross
  const V4 turned = fnma4(KS_PERMUTE(a, 1, 2, 0), b, a * KS_PERMUTE(b, 1, 2, 0));
  return KS_PERMUTE(turned, 1, 2, 0);
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
static __attribute__((noinline, cold)) void large_sines_of(const Program &c, V x, int from, double *sine, double *cosine) {
  double angle[LANES];
  store(angle, x);
  for (int k = 0; k < LANES && from + k < c.joints; k++) {
    double same[LANES], s[LANES], co[LANES];
    for (int w = 0; w < LANES; w++) same[w] = angle[k], s[w] = sine[from + k], co[w] = cosine[from + k];
    sincos_large(same, c.joint[from + k].quarter, s, co);
    sine[from + k] = s[0], cosine[from + k] = co[0];
  }
}
// Sines of M times LANES joints: block m begins at joint from[m] and reads its angles from q[m].
template <int M>
KS_INLINE void sines_of(const Program &c, const double *const *q, const int *from, double *sine, double *cosine) {
  V x[M], rounder[M], s[M], co[M];
  KS_UNROLL
  for (int m = 0; m < M; m++) {
    x[m] = fma_(load(c.turns.scale + from[m]), load(q[m]), load(c.turns.offset + from[m]));
    rounder[m] = load(c.turns.rounder + from[m]);
  }
  sincos_small<M>(x, rounder, s, co);
  KS_UNROLL
  for (int m = 0; m < M; m++) {
    store(sine + from[m], s[m]), store(cosine + from[m], co[m]);
    if (__builtin_expect(any(is_large(x[m])), 0)) large_sines_of(c, x[m], from[m], sine, cosine);
  }
}
KS_INLINE void sines_one(const Program &c, const double *q, double *sine, double *cosine) {
  const int n = c.joints;
  if (c.turns.in_order && n >= LANES) {  // straight from q; the last block overlaps the one before
    int i = 0;
    for (; i + LANES < n; i += 2 * LANES) {
      const int from[] = {i, i + 2 * LANES <= n ? i + LANES : n - LANES};
      const double *const angles[] = {q + from[0], q + from[1]};
      sines_of<2>(c, angles, from, sine, cosine);
    }
    if (i < n) {
      const int from = n - LANES;
      const double *const angles = q + from;
      sines_of<1>(c, &angles, &from, sine, cosine);
    }
  } else {
    for (int i = 0; i < n; i += LANES) {
      double gathered[LANES];
      for (int k = 0; k < LANES; k++) gathered[k] = q[c.joint[i + k < n ? i + k : i].column];
      const double *const angles = gathered;
      sines_of<1>(c, &angles, &i, sine, cosine);
    }
  }
  if (c.slides)
    for (int i = 0; i < n; i++)
      if (c.joint[i].kind == kinestatics::PRISMATIC) sine[i] = c.joint[i].sine, cosine[i] = c.joint[i].cosine;
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
    if (__builtin_expect(j.plain, 1)) {
      v = cross4(axis[i], at - origin[i]), w = axis[i];
    } else if (j.kind == kinestatics::PRISMATIC) {
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
