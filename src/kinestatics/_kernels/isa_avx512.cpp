#define LANES 8
#include "kernels.hpp"

namespace kinestatics {
extern const Kernels kernels_avx512;
const Kernels kernels_avx512 = table("avx512");
}  // namespace kinestatics
