#define LANES 4
#include "kernels.hpp"

namespace kinestatics {
extern const Kernels kernels_avx2;
const Kernels kernels_avx2 = table("avx2");
}  // namespace kinestatics
