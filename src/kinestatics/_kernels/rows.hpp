// Between arrays of configurations (one row each) and lanes: transposition in registers, and output in whole cache lines.
#pragma once
#include <cstdint>

#include "lanes.hpp"

namespace {  // every instruction set has its own copy: nothing here may be shared by the linker


// a[e] holds entry e of LANES configurations; afterwards row w of `out` holds entries 0 .. LANES-1 of configuration w.
#if LANES == 8
#define KS_LOW(x, y) KS_SHUFFLE(VInt, x, y, 0, 1, 8, 9, 4, 5, 12, 13)
#define KS_HIGH(x, y) KS_SHUFFLE(VInt, x, y, 2, 3, 10, 11, 6, 7, 14, 15)
#define KS_EVEN(x, y) KS_SHUFFLE(VInt, x, y, 0, 8, 2, 10, 4, 12, 6, 14)
#define KS_ODD(x, y) KS_SHUFFLE(VInt, x, y, 1, 9, 3, 11, 5, 13, 7, 15)
#define KS_FIRST(x, y) KS_SHUFFLE(VInt, x, y, 0, 1, 2, 3, 8, 9, 10, 11)
#define KS_SECOND(x, y) KS_SHUFFLE(VInt, x, y, 4, 5, 6, 7, 12, 13, 14, 15)
KS_INLINE void transpose(const V *a, V *out) {
  const V b0 = KS_EVEN(a[0], a[1]), b1 = KS_ODD(a[0], a[1]), b2 = KS_EVEN(a[2], a[3]), b3 = KS_ODD(a[2], a[3]);
  const V b4 = KS_EVEN(a[4], a[5]), b5 = KS_ODD(a[4], a[5]), b6 = KS_EVEN(a[6], a[7]), b7 = KS_ODD(a[6], a[7]);
  const V c0 = KS_LOW(b0, b2), c2 = KS_HIGH(b0, b2), c1 = KS_LOW(b1, b3), c3 = KS_HIGH(b1, b3);
  const V d0 = KS_LOW(b4, b6), d2 = KS_HIGH(b4, b6), d1 = KS_LOW(b5, b7), d3 = KS_HIGH(b5, b7);
  out[0] = KS_FIRST(c0, d0), out[4] = KS_SECOND(c0, d0);
  out[1] = KS_FIRST(c1, d1), out[5] = KS_SECOND(c1, d1);
  out[2] = KS_FIRST(c2, d2), out[6] = KS_SECOND(c2, d2);
  out[3] = KS_FIRST(c3, d3), out[7] = KS_SECOND(c3, d3);
}
#elif LANES == 4
KS_INLINE void transpose(const V *a, V *out) {
  const V b0 = KS_SHUFFLE(VInt, a[0], a[1], 0, 4, 2, 6), b1 = KS_SHUFFLE(VInt, a[0], a[1], 1, 5, 3, 7);
  const V b2 = KS_SHUFFLE(VInt, a[2], a[3], 0, 4, 2, 6), b3 = KS_SHUFFLE(VInt, a[2], a[3], 1, 5, 3, 7);
  out[0] = KS_SHUFFLE(VInt, b0, b2, 0, 1, 4, 5), out[2] = KS_SHUFFLE(VInt, b0, b2, 2, 3, 6, 7);
  out[1] = KS_SHUFFLE(VInt, b1, b3, 0, 1, 4, 5), out[3] = KS_SHUFFLE(VInt, b1, b3, 2, 3, 6, 7);
}
#else
KS_INLINE void transpose(const V *a, V *out) {
  out[0] = KS_SHUFFLE(VInt, a[0], a[1], 0, 2);
  out[1] = KS_SHUFFLE(VInt, a[0], a[1], 1, 3);
}
#endif

KS_INLINE void write_block(const V *entries, double *const *out, ptrdiff_t e) {
  V rows[LANES];
  transpose(entries + e, rows);
  KS_UNROLL
  for (int w = 0; w < LANES; w++) store(out[w] + e, rows[w]);
}
// `size` entries of LANES configurations into rows of `out`, one after another.
KS_INLINE void write_rows(const V *entries, int size, double *out) {
  if (size >= LANES) {
    double *row[LANES];
    KS_UNROLL
    for (int w = 0; w < LANES; w++) row[w] = out + w * (ptrdiff_t)size;
    const ptrdiff_t last = size - LANES;
    for (ptrdiff_t e = 0; e < last; e += LANES) write_block(entries, row, e);
    write_block(entries, row, last);  // may overlap the block before
    return;
  }
  for (int w = 0; w < LANES; w++)
    for (int e = 0; e < size; e++) out[w * size + e] = entries[e][w];
}
// The first `size` entries of LANES rows (each `size` long, contiguous, `readable` doubles in all) into lanes.
KS_INLINE void read_rows(const double *rows, int size, ptrdiff_t readable, V *entries) {
  int e = 0;
  for (; e < size && (LANES - 1) * (ptrdiff_t)size + e + LANES <= readable; e += LANES) {
    V from[LANES], to[LANES];
    KS_UNROLL
    for (int w = 0; w < LANES; w++) from[w] = load(rows + w * (ptrdiff_t)size + e);
    transpose(from, to);
    KS_UNROLL
    for (int w = 0; w < LANES; w++) entries[e + w] = to[w];  // up to LANES - 1 entries past the end are scratch
  }
  for (; e < size; e++) {
    V v{};
    KS_UNROLL
    for (int w = 0; w < LANES; w++) v[w] = rows[w * (ptrdiff_t)size + e];
    entries[e] = v;
  }
}

// Large outputs bypass the caches: rows are put together in a buffer and leave it as whole 64-byte lines, one block late,
// since a line that was only just put together would wait for its own stores. The buffer has two halves, one filled while
// the other waits. The first and the last line may belong partly to someone else; these are written with plain stores.
class LineWriter {
 public:
  static constexpr size_t half(size_t entries) { return (entries * LANES + 15) / 8 * 8; }  // doubles; two are needed
  LineWriter(double *out, double *buffer, int size) : ready_(buffer), free_(buffer + half(size)), begin_(out) {
    left_ = (int)(((uintptr_t)out & 63) / sizeof(double));
    line_ = out - left_;
  }
  KS_INLINE_METHOD void put(const V *entries, int size) {
    for (int k = 0; k < left_; k++) free_[k] = ready_[whole_ + k];  // the beginning of a line that this block completes
    write_rows(entries, size, free_ + left_);
    send();
    const int filled = left_ + size * LANES;
    whole_ = filled & ~7, left_ = filled & 7;
    double *const sent = ready_;
    ready_ = free_, free_ = sent;
  }
  void finish() {
    send();
    for (int k = 0; k < left_; k++)
      if (line_ + k >= begin_) line_[k] = ready_[whole_ + k];
#if defined(__x86_64__)
    _mm_sfence();
#endif
  }

 private:
  KS_INLINE_METHOD void send() {
    int k = 0;
    if (__builtin_expect(line_ < begin_, 0) && whole_) {
      for (k = (int)(begin_ - line_); k < 8; k++) line_[k] = ready_[k];
    }
    KS_UNROLL
    for (; k < whole_; k += 8) stream_line(line_ + k, ready_ + k);
    line_ += whole_;
  }
  KS_INLINE void stream_line(double *to, const double *from) {
#if !defined(__x86_64__)
    std::memcpy(to, from, 64);
#elif LANES == 8
    _mm512_stream_pd(to, _mm512_load_pd(from));
#elif LANES == 4
    _mm256_stream_pd(to, _mm256_load_pd(from));
    _mm256_stream_pd(to + 4, _mm256_load_pd(from + 4));
#else
    for (int k = 0; k < 8; k += 2) _mm_stream_pd(to + k, _mm_load_pd(from + k));
#endif
  }
  double *ready_, *free_;   // ready_[k] belongs at line_[k]: whole lines that wait, then the beginning of one more
  double *line_, *begin_;
  int whole_ = 0, left_;
};

}  // namespace
