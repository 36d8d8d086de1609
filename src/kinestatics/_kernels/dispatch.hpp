// Which instruction set this processor has.
#pragma once
#include <cstring>

#include "program.hpp"

namespace kinestatics {

extern const Kernels kernels_baseline;
#if defined(__x86_64__)
extern const Kernels kernels_avx2, kernels_avx512;
#endif

inline bool supported(const char *name) {
#if defined(__x86_64__)
  __builtin_cpu_init();
  const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  if (!std::strcmp(name, "avx2")) return avx2;
  if (!std::strcmp(name, "avx512"))
    return avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl");
#endif
  return !std::strcmp(name, "baseline");
}
// The table of that name, or the best one when `name` is null; null where this processor cannot run it.
inline const Kernels *find_kernels(const char *name) {
  const Kernels *all[] = {
#if defined(__x86_64__)
      &kernels_avx512, &kernels_avx2,
#endif
      &kernels_baseline};
  for (const Kernels *k : all)
    if ((!name || !std::strcmp(k->name, name)) && supported(k->name)) return k;
  return nullptr;
}

}  // namespace kinestatics
