// What one core can write: whole cache lines past the caches. `bytes` is a multiple of 64, `out` is aligned to 64.
#include <cstddef>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

extern "C" void write_limit(double *out, size_t bytes) {
  const size_t n = bytes / sizeof(double);
#if defined(__x86_64__)
  const __m128d x = _mm_set1_pd(1.0);
  for (size_t i = 0; i < n; i += 8) {
    _mm_stream_pd(out + i, x), _mm_stream_pd(out + i + 2, x);
    _mm_stream_pd(out + i + 4, x), _mm_stream_pd(out + i + 6, x);
  }
  _mm_sfence();
#else
  for (size_t i = 0; i < n; i++) out[i] = 1.0;
#endif
}
