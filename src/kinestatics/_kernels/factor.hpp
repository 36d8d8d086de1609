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
KS_INLINE void select_rows(const Program &c, const Sides &s, const V *J, V *A) {
  for (int a = 0; a < s.count; a++)
    for (int i = 0; i < s.length; i++) A[a * s.length + i] = J[c.rows[s.wide ? a : i] * c.columns + (s.wide ? i : a)];
}
KS_INLINE V dot(const V *a, const V *b, int length) {
  V sum = a[0] * b[0];
  for (int i = 1; i < length; i++) sum = fma_(a[i], b[i], sum);
  return sum;
}
KS_INLINE void subtract(V *a, V factor, const V *b, int length) {
  for (int i = 0; i < length; i++) a[i] = fnma_(factor, b[i], a[i]);
}
// Product of the lengths that remain when each vector has lost its part along those before (modified Gram-Schmidt):
// absolute error a few units in the last place, where det(J Jt) would lose half the digits.
template <int K>
KS_INLINE V volume(V *A, int length) {
  V product = broadcast(1);
  KS_UNROLL
  for (int r = 0; r < K; r++) {
    V *a = A + r * length;
    const V square = dot(a, a, length);
    product *= square;
    const V inverse = 1.0 / select(square > 0, square, broadcast(1));
    KS_UNROLL
    for (int s = r + 1; s < K; s++) subtract(A + s * length, dot(a, A + s * length, length) * inverse, a, length);
  }
  return square_root(product);
}
KS_INLINE V volume(V *A, const Sides &s) {
  switch (s.count) {
    case 6: return volume<6>(A, s.length);
    case 5: return volume<5>(A, s.length);
    case 4: return volume<4>(A, s.length);
    case 3: return volume<3>(A, s.length);
    case 2: return volume<2>(A, s.length);
    case 1: return volume<1>(A, s.length);
    default: return broadcast(1);  // the empty product
  }
}
static void k_manipulability(const Program *cp, const double *q, ptrdiff_t n, double *out, double *scratch) {
  const Program &c = *cp;
  Block b = carve(c, scratch);
  const Sides s = sides(c);
  V *A = b.entries + 6 * c.columns, *result = b.second;
  clear(b.entries, 6 * c.columns);
  const Input in[] = {{q, c.columns, b.q}};
  sweep(in, 1, n, result, 1, out, line_buffer(c, scratch), [&]() __attribute__((always_inline)) {
    jacobian_block(c, b.q, b);
    select_rows(c, s, b.entries, A);
    result[0] = volume(A, s);
  });
}

// R of a QR factorisation of the K vectors, as columns of a K x K matrix in D (D[column][row]).
KS_INLINE void triangle(V *A, const Sides &s, V (*D)[6]) {
  for (int r = 0; r < s.count; r++) {
    V *a = A + r * s.length;
    const V square = dot(a, a, s.length);
    const VInt positive = square > 0;
    const V inverse = select(positive, reciprocal_root(select(positive, square, broadcast(1))), broadcast(0));
    D[r][r] = square * inverse;
    for (int i = 0; i < s.length; i++) a[i] *= inverse;
    for (int t = r + 1; t < s.count; t++) {
      const V d = dot(a, A + t * s.length, s.length);
      D[r][t] = d;
      D[t][r] = broadcast(0);
      subtract(A + t * s.length, d, a, s.length);
    }
  }
}
// One-sided Jacobi (Hestenes 1958) on K vectors of K entries: turn pairs until all are at right angles; their lengths are
// the singular values, small ones with small error. A lane that is done stands still while its neighbours go on, so that
// a configuration's bits do not depend on which others share its block.
template <int K>
KS_INLINE void orthogonalize(V (*D)[6]) {
  VInt active = ~VInt{};
  for (int sweep_count = 0; sweep_count < 16; sweep_count++) {
    V squares[K];
    VInt busy{};
    KS_UNROLL
    for (int p = 0; p < K; p++) squares[p] = dot(D[p], D[p], K);
#pragma GCC unroll 1
    for (int p = 0; p < K - 1; p++)
#pragma GCC unroll 1
      for (int r = p + 1; r < K; r++) {
        const V g = dot(D[p], D[r], K), a = squares[p], b = squares[r], product = a * b, g2 = g * g;
        const VInt turn = (g2 > product * 1e-32) & active;
        busy |= g2 > product * 1e-16;
        const V difference = b - a, twice = 2.0 * g;
        const V reach = absolute(difference) + square_root(fma_(difference, difference, twice * twice));
        V t = with_sign_of(twice, difference) / select(reach > 0, reach, broadcast(1));
        t = select(turn, t, broadcast(0));
        const V cosine = select(turn, reciprocal_root(fma_(t, t, broadcast(1))), broadcast(1)), sine = cosine * t;
        squares[p] = fnma_(t, g, a);
        squares[r] = fma_(t, g, b);
        KS_UNROLL
        for (int i = 0; i < K; i++) {
          const V x = D[p][i], y = D[r][i];
          D[p][i] = fnma_(sine, y, cosine * x);
          D[r][i] = fma_(sine, x, cosine * y);
        }
      }
    active &= busy;
    if (!any(active)) return;
  }
}
KS_INLINE void orthogonalize(V (*D)[6], int count) {
  switch (count) {
    case 6: return orthogonalize<6>(D);
    case 5: return orthogonalize<5>(D);
    case 4: return orthogonalize<4>(D);
    case 3: return orthogonalize<3>(D);
    case 2: return orthogonalize<2>(D);
    default: return;
  }
}
static void k_singular_values(const Program *cp, const double *q, ptrdiff_t n, double *out, double *scratch) {
  const Program &c = *cp;
  Block b = carve(c, scratch);
  const Sides s = sides(c);
  V *A = b.entries + 6 * c.columns, *sigma = b.second;
  clear(b.entries, 6 * c.columns);
  if (s.count == 0) return;
  const Input in[] = {{q, c.columns, b.q}};
  sweep(in, 1, n, sigma, s.count, out, line_buffer(c, scratch), [&]() __attribute__((always_inline)) {
    V D[6][6];
    jacobian_block(c, b.q, b);
    select_rows(c, s, b.entries, A);
    triangle(A, s, D);
    orthogonalize(D, s.count);
    for (int p = 0; p < s.count; p++) sigma[p] = square_root(dot(D[p], D[p], s.count));
    for (int p = 1; p < s.count; p++)  // descending, by exchanges of neighbours
      for (int k = p; k > 0; k--) {
        const V x = sigma[k - 1], y = sigma[k];
        const VInt wrong = x < y;
        sigma[k - 1] = select(wrong, y, x), sigma[k] = select(wrong, x, y);
      }
  });
}

// y = (A + damping^2 I)^-1 y for a symmetric positive matrix given by its lower triangle, by LDLt.
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
template <int K>
KS_INLINE void damped_block(const Program &c, const Sides &s, const V *A, const V *twist, V damping2, V *rates) {
  V S[6][6], y[6];
  KS_UNROLL
  for (int r = 0; r < K; r++) {
    for (int t = 0; t <= r; t++) S[r][t] = dot(A + r * s.length, A + t * s.length, s.length);
    S[r][r] += damping2;
    if (s.wide) {
      y[r] = twist[c.rows[r]];
    } else {
      y[r] = broadcast(0);
      for (int i = 0; i < s.length; i++) y[r] = fma_(A[r * s.length + i], twist[c.rows[i]], y[r]);
    }
  }
  solve<K>(S, y);
  if (!s.wide) {
    for (int k = 0; k < K; k++) rates[k] = y[k];
    return;
  }
  for (int k = 0; k < s.length; k++) {
    V sum = A[k] * y[0];
    KS_UNROLL
    for (int r = 1; r < K; r++) sum = fma_(A[r * s.length + k], y[r], sum);
    rates[k] = sum;
  }
}
static void k_damped_rates(const Program *cp, const double *q, const double *twist, double damping, ptrdiff_t n, double *out,
                           double *scratch) {
  const Program &c = *cp;
  Block b = carve(c, scratch);
  const Sides s = sides(c);
  V *A = b.entries + 6 * c.columns, *rates = (V *)b.extra, lanes[8];
  clear(b.entries, 6 * c.columns);
  clear(rates, c.columns);
  const V damping2 = broadcast(damping * damping);
  const Input in[] = {{q, c.columns, b.q}, {twist, 6, lanes}};
  sweep(in, 2, n, rates, c.columns, out, line_buffer(c, scratch), [&]() __attribute__((always_inline)) {
    jacobian_block(c, b.q, b);
    select_rows(c, s, b.entries, A);
    switch (s.count) {
      case 6: return damped_block<6>(c, s, A, lanes, damping2, rates);
      case 5: return damped_block<5>(c, s, A, lanes, damping2, rates);
      case 4: return damped_block<4>(c, s, A, lanes, damping2, rates);
      case 3: return damped_block<3>(c, s, A, lanes, damping2, rates);
      case 2: return damped_block<2>(c, s, A, lanes, damping2, rates);
      case 1: return damped_block<1>(c, s, A, lanes, damping2, rates);
      default: return;
    }
  });
}

}  // namespace
