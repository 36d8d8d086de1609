// Manipulability, singular values and damped joint rates from the rows in play of J, without leaving the registers' reach.
#pragma once
#include "quantities.hpp"

namespace {

// The short side of the selected rows as K vectors: rows of J where it is wide, columns where it is tall.
struct Sides {
  int count, length;  // K vectors of `length` entries
  bool wide;
};
KS_INLINE Sides sides(const Program &c) {
  const bool wide = c.row_count <= c.columns;
  return {wide ? c.row_count : c.columns, wide ? c.columns : c.row_count, wide};
}
// Calls f with the sizes as compile-time constants: six rows of arms of six and seven joints in full, for speed; for all
// others the count alone (LENGTH 0: known at run time).
template <int COUNT, int LENGTH>
struct Sizes {
  KS_INLINE_METHOD int length(const Sides &s) const { return LENGTH ? LENGTH : s.length; }
};
template <class F>
KS_INLINE void with_sizes(const Sides &s, F f) {
  switch (s.count) {
    case 6: return s.length == 6 ? f(Sizes<6, 6>()) : s.length == 7 ? f(Sizes<6, 7>()) : f(Sizes<6, 0>());
    case 5: return f(Sizes<5, 0>());
    case 4: return f(Sizes<4, 0>());
    case 3: return f(Sizes<3, 0>());
    case 2: return f(Sizes<2, 0>());
    case 1: return f(Sizes<1, 0>());
    default: return;
  }
}
KS_INLINE void select_rows(const Program &c, const Sides &s, const V *J, V *A) {
  for (int a = 0; a < s.count; a++)
    for (int i = 0; i < s.length; i++) A[a * s.length + i] = J[c.rows[s.wide ? a : i] * c.columns + (s.wide ? i : a)];
}
KS_INLINE V dot(const V *a, const V *b, int length) {
  V sum = a[0] * b[0];
  for (int i = 1; i < length; i++) sum = fma_(a[i], b[i], sum);
  return sum;
}
// Squares below this are taken for zero: their digits, or their inverse, are lost (lengths below 1e-146).
static constexpr double TINY_SQUARE = 1e-292;
KS_INLINE void subtract(V *a, V factor, const V *b, int length) {
  for (int i = 0; i < length; i++) a[i] = fnma_(factor, b[i], a[i]);
}
// Product of the lengths that remain when each vector has lost its part along those before (modified Gram-Schmidt):
// absolute error a few units in the last place, where det(J Jt) would lose half the digits.
template <int K, int LENGTH>
KS_INLINE V volume(V *A, const Sides &s, Sizes<K, LENGTH> sizes) {
  const int length = sizes.length(s);
  V product = broadcast(1);
  KS_UNROLL
  for (int r = 0; r < K; r++) {
    V *a = A + r * length;
    const V square = dot(a, a, length);
    product *= square;
    const V inverse = 1.0 / select(square < TINY_SQUARE, broadcast(HUGE_VAL), square);
    KS_UNROLL
    for (int t = r + 1; t < K; t++) subtract(A + t * length, dot(a, A + t * length, length) * inverse, a, length);
  }
  return square_root(product);
}
// R of a QR factorisation of the K vectors, as columns of a K x K matrix in D (D[column][row]).
template <int K, int LENGTH>
KS_INLINE void triangle(V *A, const Sides &s, Sizes<K, LENGTH> sizes, V (*D)[6]) {
  const int length = sizes.length(s);
  for (int r = 0; r < K; r++) {
    V *a = A + r * length;
    const V square = dot(a, a, length);
    const VInt positive = square >= TINY_SQUARE;
    const V inverse = select(positive, reciprocal_root(select(positive, square, broadcast(1))), broadcast(0));
    D[r][r] = square * inverse;
    for (int i = 0; i < length; i++) a[i] *= inverse;
    for (int t = r + 1; t < K; t++) {
      const V d = dot(a, A + t * length, length);
      D[r][t] = d;
      D[t][r] = broadcast(0);
      subtract(A + t * length, d, a, length);
    }
  }
}
// The pairs of K vectors in rounds of disjoint ones (a round robin): within a round they do not wait for each other.
template <int K>
struct Rounds {
  static constexpr int COUNT = K + K % 2 - 1, PAIRS = K / 2;
  int first[COUNT][PAIRS] = {}, second[COUNT][PAIRS] = {};
  constexpr Rounds() {
    for (int r = 0; r < COUNT; r++) {
      int m = 0;
      if (K % 2 == 0) first[r][m] = r, second[r][m++] = COUNT;
      for (int i = 1; 2 * i < COUNT; i++) first[r][m] = (r + i) % COUNT, second[r][m++] = (r + COUNT - i) % COUNT;
    }
  }
};
// One-sided Jacobi (Hestenes 1958) on K vectors of K entries: turn pairs until all are at right angles; their lengths are
// the singular values, small ones with small error. A lane that is done stands still while its neighbours go on, so that
// a configuration's bits do not depend on which others share its block.
// A power of two of the size of the largest entry, and its inverse: products of squares of what is left neither overflow
// nor vanish, and scaling by it rounds nothing.
KS_INLINE V scale_of(const V *A, int count, V &inverse) {
  V largest = broadcast(0);
  for (int i = 0; i < count; i++) {
    const V size = absolute(A[i]);
    largest = select(size > largest, size, largest);
  }
  const long long bit = 1LL << 52;
  VInt exponent = (VInt)largest & (2047 * bit);
  exponent = (VInt)select(exponent < 23 * bit, (V)(VInt{} + 23 * bit), (V)exponent);  // as far as the inverse is a double
  exponent = (VInt)select(exponent > 2023 * bit, (V)(VInt{} + 2023 * bit), (V)exponent);
  inverse = (V)(2046 * bit - exponent);
  return (V)exponent;
}
template <int LENGTH>
KS_INLINE void orthogonalize(Sizes<1, LENGTH>, V (*)[6]) {}
template <int K, int LENGTH>
KS_INLINE void orthogonalize(Sizes<K, LENGTH>, V (*D)[6]) {
  static constexpr Rounds<K> rounds;
  constexpr int PAIRS = K / 2;
  const V zero = broadcast(0), one = broadcast(1);
  VInt active = ~VInt{};
  for (int sweep_count = 0; sweep_count < 16; sweep_count++) {
    V squares[K];
    VInt busy{};
    for (int p = 0; p < K; p++) squares[p] = dot(D[p], D[p], K);
    for (int round = 0; round < rounds.COUNT; round++) {
      V *x[PAIRS], *y[PAIRS], cosine[PAIRS], sine[PAIRS];
      KS_UNROLL
      for (int m = 0; m < PAIRS; m++) {
        const int p = rounds.first[round][m], r = rounds.second[round][m];
        x[m] = D[p], y[m] = D[r];
        const V g = dot(x[m], y[m], K), a = squares[p], b = squares[r], product = a * b, g2 = g * g;
        const VInt turn = (g2 > product * 1e-32) & active;
        busy |= g2 > product * 1e-16;
        const V difference = b - a, twice = 2.0 * g;
        const V reach = absolute(difference) + square_root(fma_(difference, difference, twice * twice));
        const V t = select(turn, times_sign_of(twice, difference) / select(reach > 0, reach, one), zero);
        cosine[m] = select(turn, reciprocal_root(fma_(t, t, one)), one), sine[m] = cosine[m] * t;
        squares[p] = fnma_(t, g, a);
        squares[r] = fma_(t, g, b);
      }
      KS_UNROLL
      for (int m = 0; m < PAIRS; m++) {
        KS_UNROLL
        for (int i = 0; i < K; i++) {
          const V u = x[m][i], v = y[m][i];
          x[m][i] = fnma_(sine[m], v, cosine[m] * u);
          y[m][i] = fma_(sine[m], u, cosine[m] * v);
        }
      }
    }
    active &= busy;
    if (!any(active)) return;
  }
}
// All singular values of the rows in play, descending.
KS_INLINE void singular_values_of(const Program &c, const Sides &s, const V *J, V *A, V *sigma) {
  V D[6][6], inverse;
  select_rows(c, s, J, A);
  const V scale = scale_of(A, s.count * s.length, inverse);
  for (int i = 0; i < s.count * s.length; i++) A[i] *= inverse;
  with_sizes(s, [&](auto sizes) __attribute__((always_inline)) {
    triangle(A, s, sizes, D);
    orthogonalize(sizes, D);
  });
  for (int p = 0; p < s.count; p++) sigma[p] = scale * square_root(dot(D[p], D[p], s.count));
  for (int p = 1; p < s.count; p++)  // by exchanges of neighbours
    for (int k = p; k > 0; k--) {
      const V x = sigma[k - 1], y = sigma[k];
      const VInt wrong = x < y;
      sigma[k - 1] = select(wrong, y, x), sigma[k] = select(wrong, x, y);
    }
}
static void k_singular_values(const Program *cp, const double *q, ptrdiff_t n, double *out, double *scratch) {
  const Program &c = *cp;
  Block b = carve(c, scratch);
  const Sides s = sides(c);
  clear(b.entries, 6 * c.columns);
  if (s.count == 0) return;
  const Input in[] = {{q, c.columns, b.q}};
  sweep(in, 1, n, b.result, s.count, out, line_buffer(c, scratch), [&]() __attribute__((always_inline)) {
    jacobian_block(c, b.q, b);
    singular_values_of(c, s, b.entries, b.entries + 6 * c.columns, b.result);
  });
}
// The product of as many singular values as the arm can have: all of them by QR, or the largest where some are zero in
// every posture.
static void k_manipulability(const Program *cp, const double *q, ptrdiff_t n, double *out, double *scratch) {
  const Program &c = *cp;
  Block b = carve(c, scratch);
  const Sides s = sides(c);
  V *A = b.entries + 6 * c.columns, *result = b.result;
  clear(b.entries, 6 * c.columns);
  const Input in[] = {{q, c.columns, b.q}};
  if (c.rank == s.count) {
    sweep(in, 1, n, result, 1, out, line_buffer(c, scratch), [&]() __attribute__((always_inline)) {
      jacobian_block(c, b.q, b);
      select_rows(c, s, b.entries, A);
      result[0] = broadcast(1);  // the empty product
      with_sizes(s, [&](auto sizes) __attribute__((always_inline)) { result[0] = volume(A, s, sizes); });
    });
    return;
  }
  sweep(in, 1, n, result, 1, out, line_buffer(c, scratch), [&]() __attribute__((always_inline)) {
    V sigma[6];
    jacobian_block(c, b.q, b);
    singular_values_of(c, s, b.entries, A, sigma);
    result[0] = broadcast(c.rank ? 1 : 0);
    for (int p = 0; p < c.rank; p++) result[0] *= sigma[p];
  });
}

// y = A^-1 y for a symmetric positive matrix given by its lower triangle, by LDLt.
template <int K>
KS_INLINE void solve(V (*A)[6], V *y) {
  V inverse[K];
  KS_UNROLL
  for (int j = 0; j < K; j++) {
    inverse[j] = 1.0 / A[j][j];
    KS_UNROLL
    for (int r = j + 1; r < K; r++) {
      const V factor = A[r][j] * inverse[j];
      KS_UNROLL
      for (int s = j + 1; s <= r; s++) A[r][s] = fnma_(factor, A[s][j], A[r][s]);
      y[r] = fnma_(factor, y[j], y[r]);
    }
  }
  KS_UNROLL
  for (int j = K - 1; j >= 0; j--) {
    V sum = y[j];
    KS_UNROLL
    for (int r = j + 1; r < K; r++) sum = fnma_(A[r][j], y[r], sum);
    y[j] = sum * inverse[j];
  }
}
template <int K, int LENGTH>
KS_INLINE void damped_block(const Program &c, const Sides &s, Sizes<K, LENGTH> sizes, const V *A, const V *twist, V damping2,
                            V *rates) {
  const int length = sizes.length(s);
  V S[6][6], y[6];
  KS_UNROLL
  for (int r = 0; r < K; r++) {
    KS_UNROLL
    for (int t = 0; t <= r; t++) S[r][t] = dot(A + r * length, A + t * length, length);
    S[r][r] += damping2;
    if (LENGTH > 6 || s.wide) {
      y[r] = twist[c.rows[r]];
    } else {
      y[r] = broadcast(0);
      for (int i = 0; i < length; i++) y[r] = fma_(A[r * length + i], twist[c.rows[i]], y[r]);
    }
  }
  solve<K>(S, y);
  if (!s.wide) {
    for (int k = 0; k < K; k++) rates[k] = y[k];
    return;
  }
  for (int k = 0; k < length; k++) {
    V sum = A[k] * y[0];
    KS_UNROLL
    for (int r = 1; r < K; r++) sum = fma_(A[r * length + k], y[r], sum);
    rates[k] = sum;
  }
}
static void k_damped_rates(const Program *cp, const double *q, const double *twist, double damping, ptrdiff_t n, double *out,
                           double *scratch) {
  const Program &c = *cp;
  Block b = carve(c, scratch);
  const Sides s = sides(c);
  V *A = b.entries + 6 * c.columns, *rates = b.result, lanes[8];
  clear(b.entries, 6 * c.columns);
  clear(rates, c.columns);
  const V damping2 = broadcast(damping * damping);
  const Input in[] = {{q, c.columns, b.q}, {twist, 6, lanes}};
  sweep(in, 2, n, rates, c.columns, out, line_buffer(c, scratch), [&]() __attribute__((always_inline)) {
    jacobian_block(c, b.q, b);
    select_rows(c, s, b.entries, A);
    with_sizes(s, [&](auto sizes) __attribute__((always_inline)) { damped_block(c, s, sizes, A, lanes, damping2, rates); });
  });
}

}  // namespace
