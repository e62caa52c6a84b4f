#pragma once

#include "devices/device.h"

namespace palpate {

/// The data sheet of an arm of Force Dimension's, by dhdGetSystemType; model, rate and torque axes
/// are left to the driver, which asks the library.  Figures have their sources in the .cpp.  An arm
/// that is not known gets the weakest bounds there are.
DeviceInfo ForceDimensionSheet(int system_type);

}  // namespace palpate
