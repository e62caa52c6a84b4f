#include "devices/openhaptics/hd_abi.h"

#include <type_traits>

#include <gtest/gtest.h>

#include "devices/openhaptics/hd_error.h"

// A second entry of the figures, from the public documentation and not from the header: a slip of
// the pen in either shows.
namespace palpate::hd {
namespace {

static_assert(sizeof(Handle) == 4 && sizeof(SchedulerHandle) == 8 && sizeof(long) == 8);
static_assert(sizeof(ErrorInfo) == 12 && std::is_trivially_copyable_v<ErrorInfo>);

TEST(HdAbi, HasTheDocumentedNumbersForWhatIsAskedAndSet) {
  EXPECT_EQ(kCurrentButtons, 0x2000u);
  EXPECT_EQ(kCurrentInkwellSwitch, 0x2002u);
  EXPECT_EQ(kCurrentEncoderValues, 0x2010u);
  EXPECT_EQ(kCurrentVelocity, 0x2051u);
  EXPECT_EQ(kCurrentTransform, 0x2052u);
  EXPECT_EQ(kCurrentAngularVelocity, 0x2053u);
  EXPECT_EQ(kVersion, 0x2500u);
  EXPECT_EQ(kDeviceModelType, 0x2501u);
  EXPECT_EQ(kDriverVersion, 0x2502u);
  EXPECT_EQ(kSerialNumber, 0x2504u);
  EXPECT_EQ(kMaxWorkspace, 0x2550u);
  EXPECT_EQ(kInputDof, 0x2553u);
  EXPECT_EQ(kOutputDof, 0x2554u);
  EXPECT_EQ(kCalibrationStyle, 0x2555u);
  EXPECT_EQ(kNominalMaxForce, 0x2603u);
  EXPECT_EQ(kNominalMaxContinuousForce, 0x2604u);
  EXPECT_EQ(kMotorTemperature, 0x2605u);
  EXPECT_EQ(kSoftwareVelocityLimit, 0x2606u);
  EXPECT_EQ(kSoftwareForceImpulseLimit, 0x2607u);
  EXPECT_EQ(kNominalMaxTorque, 0x2622u);
  EXPECT_EQ(kNominalMaxContinuousTorque, 0x2623u);
  EXPECT_EQ(kCurrentForce, 0x2700u);
  EXPECT_EQ(kCurrentTorque, 0x2701u);
  EXPECT_EQ(kForceOutput, 0x4000u);
  EXPECT_EQ(kMaxForceClamping, 0x4001u);
  EXPECT_EQ(kForceRamping, 0x4002u);
  EXPECT_EQ(kSoftwareForceLimit, 0x4003u);
  EXPECT_EQ(kOneFrameLimit, 0x4004u);
  EXPECT_EQ(kCalibrationOk, 0x5000u);
  EXPECT_EQ(kCalibrationNeedsUpdate, 0x5001u);
  EXPECT_EQ(kCalibrationNeedsManualInput, 0x5002u);
  EXPECT_EQ(kEncoderReset, 1u);
  EXPECT_EQ(kAuto, 2u);
  EXPECT_EQ(kInkwell, 4u);
  EXPECT_EQ(kInvalidHandle, 0xFFFFFFFFu);
  EXPECT_EQ(kDone, 0u);
  EXPECT_EQ(kContinue, 1u);
}

TEST(HdAbi, HasTheDocumentedNumbersForErrors) {
  EXPECT_EQ(kSuccess, 0u);
  EXPECT_EQ(kInvalidEnum, 0x100u);
  EXPECT_EQ(kInvalidValue, 0x101u);
  EXPECT_EQ(kInvalidOperation, 0x102u);
  EXPECT_EQ(kInvalidInputType, 0x103u);
  EXPECT_EQ(kBadHandle, 0x104u);
  EXPECT_EQ(kWarmMotors, 0x200u);
  EXPECT_EQ(kExceededMaxForce, 0x201u);
  EXPECT_EQ(kExceededMaxForceImpulse, 0x202u);
  EXPECT_EQ(kExceededMaxVelocity, 0x203u);
  EXPECT_EQ(kForceError, 0x204u);
  EXPECT_EQ(kDeviceFault, 0x300u);
  EXPECT_EQ(kDeviceAlreadyInitiated, 0x301u);
  EXPECT_EQ(kCommError, 0x302u);
  EXPECT_EQ(kCommConfigError, 0x303u);
  EXPECT_EQ(kTimerError, 0x304u);
  EXPECT_EQ(kIllegalBegin, 0x400u);
  EXPECT_EQ(kIllegalEnd, 0x401u);
  EXPECT_EQ(kFrameError, 0x402u);
  EXPECT_EQ(kInvalidPriority, 0x500u);
  EXPECT_EQ(kSchedulerFull, 0x501u);
  EXPECT_EQ(kInvalidLicense, 0x600u);
}

}  // namespace
}  // namespace palpate::hd
