#include "devices/openhaptics/hd_abi.h"

#include <type_traits>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "devices/openhaptics/hd_error.h"

// A second entry of the figures, from the public documentation and not from the header: a slip of
// the pen in either shows.
namespace palpate::hd {
namespace {

using testing::ElementsAre;

static_assert(sizeof(Handle) == 4 && sizeof(SchedulerHandle) == 8 && sizeof(long) == 8);
static_assert(sizeof(ErrorInfo) == 12 && std::is_trivially_copyable_v<ErrorInfo>);

TEST(HdAbi, HasTheDocumentedNumbers) {
  EXPECT_THAT(std::vector<unsigned>(
                  {kCurrentButtons, kCurrentInkwellSwitch, kCurrentVelocity, kCurrentTransform}),
              ElementsAre(0x2000u, 0x2002u, 0x2051u, 0x2052u));
  EXPECT_THAT(std::vector<unsigned>(
                  {kVersion, kDeviceModelType, kDriverVersion, kSerialNumber, kMaxWorkspace,
                   kInputDof, kOutputDof, kCalibrationStyle, kNominalMaxForce,
                   kNominalMaxContinuousForce, kMotorTemperature, kSoftwareVelocityLimit,
                   kSoftwareForceImpulseLimit, kNominalMaxTorque, kNominalMaxContinuousTorque}),
              ElementsAre(0x2500u, 0x2501u, 0x2502u, 0x2504u, 0x2550u, 0x2553u, 0x2554u, 0x2555u,
                          0x2603u, 0x2604u, 0x2605u, 0x2606u, 0x2607u, 0x2622u, 0x2623u));
  EXPECT_THAT(
      std::vector<unsigned>({kCurrentForce, kCurrentTorque, kForceOutput, kMaxForceClamping,
                             kForceRamping, kSoftwareForceLimit, kOneFrameLimit, kCalibrationOk,
                             kCalibrationNeedsUpdate, kCalibrationNeedsManualInput}),
      ElementsAre(0x2700u, 0x2701u, 0x4000u, 0x4001u, 0x4002u, 0x4003u, 0x4004u, 0x5000u, 0x5001u,
                  0x5002u));
  EXPECT_THAT(std::vector<unsigned>(
                  {kEncoderReset, kAuto, kInkwell, kInvalidHandle, kDone, kContinue, kSuccess}),
              ElementsAre(1u, 2u, 4u, 0xFFFFFFFFu, 0u, 1u, 0u));
  EXPECT_THAT(
      std::vector<unsigned>(
          {kInvalidEnum,         kInvalidValue,    kInvalidOperation, kInvalidInputType,
           kBadHandle,           kWarmMotors,      kExceededMaxForce, kExceededMaxForceImpulse,
           kExceededMaxVelocity, kForceError,      kDeviceFault,      kDeviceAlreadyInitiated,
           kCommError,           kCommConfigError, kTimerError,       kIllegalBegin,
           kIllegalEnd,          kFrameError,      kInvalidPriority,  kSchedulerFull,
           kInvalidLicense}),
      ElementsAre(0x100u, 0x101u, 0x102u, 0x103u, 0x104u, 0x200u, 0x201u, 0x202u, 0x203u, 0x204u,
                  0x300u, 0x301u, 0x302u, 0x303u, 0x304u, 0x400u, 0x401u, 0x402u, 0x500u, 0x501u,
                  0x600u));
}

}  // namespace
}  // namespace palpate::hd
