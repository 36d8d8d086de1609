// Vectors of LANES doubles, one lane for each configuration: arithmetic with explicit fused multiply-adds, so that every
// compiler rounds alike (build with -ffp-contract=off), and sine and cosine. GNU vector extensions: gcc and clang.
#pragma once
#include <cmath>
#include <cstring>
#if defined(__x86_64__)
#include <immintrin.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#endif

#include "program.hpp"

namespace {  // every instruction set has its own copy: nothing here may be shared by the linker

#define KS_INLINE static inline __attribute__((always_inline))
#define KS_INLINE_METHOD inline __attribute__((always_inline))
#ifdef __clang__
#define KS_UNROLL _Pragma("unroll")
#else
#define KS_UNROLL _Pragma("GCC unroll 8")
#endif

#ifdef __clang__  // gcc has clang's builtin from version 12 on; its own is older
#define KS_SHUFFLE(INTEGERS, x, y, ...) __builtin_shufflevector(x, y, __VA_ARGS__)
#else
#define KS_SHUFFLE(INTEGERS, x, y, ...) __builtin_shuffle(x, y, INTEGERS{__VA_ARGS__})
#endif

typedef double V __attribute__((vector_size(8 * LANES)));
typedef double VUnaligned __attribute__((vector_size(8 * LANES), aligned(8), may_alias));
typedef long long VInt __attribute__((vector_size(8 * LANES)));

KS_INLINE V broadcast(double x) { return x - V{}; }
KS_INLINE V load(const double *p) { return *(const VUnaligned *)p; }
KS_INLINE void store(double *p, V v) { *(VUnaligned *)p = v; }
KS_INLINE V select(VInt mask, V a, V b) { return (V)(((VInt)a & mask) | ((VInt)b & ~mask)); }
KS_INLINE V absolute(V x) { return (V)((VInt)x & 0x7fffffffffffffffLL); }
KS_INLINE V times_sign_of(V x, V sign) { return (V)(((VInt)sign & (long long)0x8000000000000000ULL) ^ (VInt)x); }

#if LANES == 8
KS_INLINE V fma_(V a, V b, V c) { return (V)_mm512_fmadd_pd((__m512d)a, (__m512d)b, (__m512d)c); }
KS_INLINE V fnma_(V a, V b, V c) { return (V)_mm512_fnmadd_pd((__m512d)a, (__m512d)b, (__m512d)c); }
KS_INLINE V square_root(V x) { return (V)_mm512_sqrt_pd((__m512d)x); }
KS_INLINE V reciprocal_root(V x) {  // two Newton steps on a 14-bit estimate
  V y = (V)_mm512_rsqrt14_pd((__m512d)x), h = x * 0.5;
  y = y * fnma_(h * y, y, broadcast(1.5));
  return y * fnma_(h * y, y, broadcast(1.5));
}
KS_INLINE bool any(VInt mask) { return _mm512_test_epi64_mask((__m512i)mask, (__m512i)mask) != 0; }
#elif LANES == 4
KS_INLINE V fma_(V a, V b, V c) { return (V)_mm256_fmadd_pd((__m256d)a, (__m256d)b, (__m256d)c); }
KS_INLINE V fnma_(V a, V b, V c) { return (V)_mm256_fnmadd_pd((__m256d)a, (__m256d)b, (__m256d)c); }
KS_INLINE V square_root(V x) { return (V)_mm256_sqrt_pd((__m256d)x); }
KS_INLINE V reciprocal_root(V x) { return 1.0 / square_root(x); }
KS_INLINE bool any(VInt mask) { return !_mm256_testz_si256((__m256i)mask, (__m256i)mask); }
#else
#if defined(__aarch64__)
KS_INLINE V fma_(V a, V b, V c) { return (V)vfmaq_f64((float64x2_t)c, (float64x2_t)a, (float64x2_t)b); }
KS_INLINE V fnma_(V a, V b, V c) { return (V)vfmsq_f64((float64x2_t)c, (float64x2_t)a, (float64x2_t)b); }
#define KS_FUSED 1
#else
KS_INLINE V fma_(V a, V b, V c) { return a * b + c; }
KS_INLINE V fnma_(V a, V b, V c) { return c - a * b; }
#endif
KS_INLINE V square_root(V x) { return V{std::sqrt(x[0]), std::sqrt(x[1])}; }
KS_INLINE V reciprocal_root(V x) { return 1.0 / square_root(x); }
KS_INLINE bool any(VInt mask) { return (mask[0] | mask[1]) != 0; }
#endif
#if LANES > 2
#define KS_FUSED 1
#endif
// (a, b) where k is even, (b, a) where it is odd.
KS_INLINE void exchange_where_odd(VInt k, V a, V b, V &first, V &second) {
#if LANES == 8
  const __mmask8 odd = _mm512_test_epi64_mask((__m512i)k, _mm512_set1_epi64(1));
  first = (V)_mm512_mask_blend_pd(odd, (__m512d)a, (__m512d)b);
  second = (V)_mm512_mask_blend_pd(odd, (__m512d)b, (__m512d)a);
#elif LANES == 4
  const __m256d odd = (__m256d)(k << 63);  // the sign bit decides
  first = (V)_mm256_blendv_pd((__m256d)a, (__m256d)b, odd);
  second = (V)_mm256_blendv_pd((__m256d)b, (__m256d)a, odd);
#else
  const VInt odd = -(k & 1);
  first = select(odd, b, a), second = select(odd, a, b);
#endif
}
KS_INLINE V fma_(double a, V b, V c) { return fma_(broadcast(a), b, c); }
KS_INLINE V fnma_(double a, V b, V c) { return fnma_(broadcast(a), b, c); }

// Beyond this the reduction below loses digits (and the quadrant no longer fits): those lanes go to the C library.
static constexpr double LARGE_ANGLE = 1e5;

// sin(x + quarter * 90 degrees) and cos likewise, for |x| <= LARGE_ANGLE: reduction to |r| <= pi/4 after Cody and Waite,
// minimax polynomials of fdlibm (Sun Microsystems, 1993). At most 2 units in the last place. `rounder` is ROUND_TO_WHOLE +
// quarter. M vectors go side by side, step by step: one alone would spend its time waiting for its own last result.
#define KS_EACH KS_UNROLL for (int m = 0; m < M; m++)
template <int M>
KS_INLINE void horner(const V *z, const double *c, int n, V *p) {
  KS_EACH p[m] = broadcast(c[0]);
  KS_UNROLL
  for (int i = 1; i < n; i++) {
    const V next = broadcast(c[i]);
    KS_EACH p[m] = fma_(p[m], z[m], next);
  }
}
template <int M>
KS_INLINE void sincos_small(const V *x, const V *rounder, V *sine, V *cosine) {
  static const double S[] = {1.58969099521155010221e-10, -2.50507602534068634195e-08, 2.75573137070700676789e-06,
                             -1.98412698298579493134e-04, 8.33333333332248946124e-03, -1.66666666666666324348e-01};
  static const double C[] = {-1.13596475577881948265e-11, 2.08757232129817482790e-09, -2.75573143513906633035e-07,
                             2.48015872894767294178e-05, -1.38888888888741095749e-03, 4.16666666666666019037e-02};
  VInt quadrant[M];
  V r[M], z[M], s[M], c[M];
  KS_EACH {
    const V shifted = fma_(x[m], broadcast(0.63661977236758134308), rounder[m]);
    quadrant[m] = (VInt)shifted;
    c[m] = shifted - rounder[m];
  }
#ifdef KS_FUSED
  KS_EACH r[m] = fnma_(c[m], broadcast(1.5707963267948966), x[m]);
  KS_EACH r[m] = fnma_(c[m], broadcast(6.123233995736766e-17), r[m]);
  KS_EACH r[m] = fnma_(c[m], broadcast(-1.4973849048591833e-33), r[m]);  // matters near multiples of pi/2
#else  // three parts short enough for exact products
  KS_EACH r[m] = x[m] - c[m] * 1.57079632673412561417e+00;
  KS_EACH r[m] = r[m] - c[m] * 6.07710050630396597660e-11;
  KS_EACH r[m] = r[m] - c[m] * 2.02226624879595063154e-21;
#endif
  KS_EACH z[m] = r[m] * r[m];
  horner<M>(z, S, 6, s);
  KS_EACH s[m] = fma_(r[m] * z[m], s[m], r[m]);
  horner<M>(z, C, 6, c);
  KS_EACH c[m] = fma_(z[m] * z[m], c[m], fnma_(broadcast(0.5), z[m], broadcast(1.0)));
  KS_EACH {
    V first, second;  // sine and cosine change places in the odd quadrants
    exchange_where_odd(quadrant[m], s[m], c[m], first, second);
    sine[m] = (V)((VInt)first ^ ((quadrant[m] & 2) << 62));
    cosine[m] = (V)((VInt)second ^ (((quadrant[m] + 1) & 2) << 62));
  }
}
#undef KS_EACH
KS_INLINE VInt is_large(V x) { return ~(absolute(x) <= LARGE_ANGLE); }  // true for NaN and infinity too

static __attribute__((noinline, cold)) void sincos_large(const double *x, long long quarter, double *sine, double *cosine) {
  for (int i = 0; i < LANES; i++) {
    if (std::fabs(x[i]) <= LARGE_ANGLE) continue;
    const double s = std::sin(x[i]), c = std::cos(x[i]);
    const double turned[5] = {s, c, -s, -c, s};
    sine[i] = turned[quarter & 3];
    cosine[i] = turned[(quarter & 3) + 1];
  }
}
KS_INLINE void sincos(V x, long long quarter, V &sine, V &cosine) {
  const V rounder = broadcast(kinestatics::ROUND_TO_WHOLE + (double)quarter);
  sincos_small<1>(&x, &rounder, &sine, &cosine);
  if (__builtin_expect(any(is_large(x)), 0)) {
    double from[LANES], s[LANES], c[LANES];
    store(from, x), store(s, sine), store(c, cosine);
    sincos_large(from, quarter, s, c);
    sine = load(s), cosine = load(c);
  }
}

}  // namespace
