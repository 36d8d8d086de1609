#define LANES 2
#include "kernels.hpp"

namespace kinestatics {
extern const Kernels kernels_baseline;
const Kernels kernels_baseline = table("baseline");
}  // namespace kinestatics
