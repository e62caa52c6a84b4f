#pragma once

#include <cstdint>

/// The binary interface of OpenHaptics' HD library (libHD.so) on 64-bit Linux, declared by the
/// project itself: building needs no vendor header, and the library is loaded at run time
/// (hd_library.h).  The values are those of OpenHaptics 3.0's public documentation.
/// Units of the library: mm, mm/s, rad, N, mN m, s; matrices are column-major.
namespace palpate::hd {

using Handle = unsigned int;
using Enum = unsigned int;
using Code = unsigned int;  ///< of an error
using SchedulerHandle = unsigned long;
using CallbackCode = unsigned int;
using Callback = CallbackCode (*)(void*);

/// The result of hdGetError, by value.
struct ErrorInfo {
  Code code;
  int internal_code;
  Handle device;
};

// The functions that the driver calls; the library has more.  X(result, name, arguments).
#define PALPATE_HD_FUNCTIONS(X)                                                              \
  X(Handle, hdInitDevice, (const char* name))                                                \
  X(void, hdMakeCurrentDevice, (Handle device))                                              \
  X(void, hdDisableDevice, (Handle device))                                                  \
  X(void, hdBeginFrame, (Handle device))                                                     \
  X(void, hdEndFrame, (Handle device))                                                       \
  X(ErrorInfo, hdGetError, (void))                                                           \
  X(void, hdEnable, (Enum what))                                                             \
  X(void, hdDisable, (Enum what))                                                            \
  X(void, hdGetBooleanv, (Enum what, unsigned char* values))                                 \
  X(void, hdGetIntegerv, (Enum what, int* values))                                           \
  X(void, hdGetDoublev, (Enum what, double* values))                                         \
  X(const char*, hdGetString, (Enum what))                                                   \
  X(void, hdSetDoublev, (Enum what, const double* values))                                   \
  X(Enum, hdCheckCalibration, (void))                                                        \
  X(void, hdUpdateCalibration, (Enum style))                                                 \
  X(void, hdStartScheduler, (void))                                                          \
  X(void, hdStopScheduler, (void))                                                           \
  X(void, hdSetSchedulerRate, (unsigned long rate_Hz))                                       \
  X(void, hdScheduleSynchronous, (Callback call, void* data, uint16_t priority))             \
  X(SchedulerHandle, hdScheduleAsynchronous, (Callback call, void* data, uint16_t priority)) \
  X(void, hdUnschedule, (SchedulerHandle handle))                                            \
  X(double, hdGetSchedulerTimeStamp, (void))

/// The library's functions, by their own names.
struct Functions {
#define PALPATE_HD_MEMBER(result, name, arguments) result(*name) arguments = nullptr;
  PALPATE_HD_FUNCTIONS(PALPATE_HD_MEMBER)
#undef PALPATE_HD_MEMBER

  template <class Visit>
  void ForEach(Visit visit) {
#define PALPATE_HD_VISIT(result, name, arguments) visit(name, #name);
    PALPATE_HD_FUNCTIONS(PALPATE_HD_VISIT)
#undef PALPATE_HD_VISIT
  }
};

inline constexpr Handle kInvalidHandle = 0xFFFFFFFF;
inline constexpr CallbackCode kDone = 0;      ///< returned by a callback to be removed
inline constexpr CallbackCode kContinue = 1;  ///< returned by a callback to be called again at the
                                              ///< next tick
inline constexpr uint16_t kDefaultPriority = 32767;

// State of the device; read it within a frame.
inline constexpr Enum kCurrentButtons = 0x2000;        // int
inline constexpr Enum kCurrentInkwellSwitch = 0x2002;  // boolean; 0 while docked
inline constexpr Enum kCurrentVelocity = 0x2051;       // double x 3, mm/s
inline constexpr Enum kCurrentTransform = 0x2052;      // double x 16, mm
inline constexpr Enum kMotorTemperature = 0x2605;      // double x 3 or 6, 0 to 1

// Properties of the device.
inline constexpr Enum kVersion = 0x2500;          // string, of the library
inline constexpr Enum kDeviceModelType = 0x2501;  // string
inline constexpr Enum kDriverVersion = 0x2502;    // string
inline constexpr Enum kSerialNumber = 0x2504;     // string
inline constexpr Enum kMaxWorkspace = 0x2550;     // double x 6: least x, y, z, greatest x, y, z; mm
inline constexpr Enum kInputDof = 0x2553;         // int
inline constexpr Enum kOutputDof = 0x2554;        // int
inline constexpr Enum kCalibrationStyle = 0x2555;            // int, bits of the supported styles
inline constexpr Enum kNominalMaxForce = 0x2603;             // double, N
inline constexpr Enum kNominalMaxContinuousForce = 0x2604;   // double, N
inline constexpr Enum kNominalMaxTorque = 0x2622;            // double, mN m
inline constexpr Enum kNominalMaxContinuousTorque = 0x2623;  // double, mN m

// The command, set within a frame: force in N, torque in mN m, Cartesian.
inline constexpr Enum kCurrentForce = 0x2700;
inline constexpr Enum kCurrentTorque = 0x2701;

// Capabilities that can be switched.
inline constexpr Enum kSoftwareVelocityLimit = 0x2606;
inline constexpr Enum kSoftwareForceImpulseLimit = 0x2607;
inline constexpr Enum kForceOutput = 0x4000;
inline constexpr Enum kMaxForceClamping = 0x4001;
inline constexpr Enum kForceRamping = 0x4002;
inline constexpr Enum kSoftwareForceLimit = 0x4003;
inline constexpr Enum kOneFrameLimit = 0x4004;

inline constexpr Enum kCalibrationOk = 0x5000;
inline constexpr Enum kCalibrationNeedsUpdate = 0x5001;
inline constexpr Enum kCalibrationNeedsManualInput = 0x5002;
inline constexpr Enum kEncoderReset = 1;
inline constexpr Enum kAuto = 2;
inline constexpr Enum kInkwell = 4;

inline constexpr Code kSuccess = 0x0000;
inline constexpr Code kInvalidEnum = 0x0100;
inline constexpr Code kInvalidValue = 0x0101;
inline constexpr Code kInvalidOperation = 0x0102;
inline constexpr Code kInvalidInputType = 0x0103;
inline constexpr Code kBadHandle = 0x0104;
inline constexpr Code kWarmMotors = 0x0200;
inline constexpr Code kExceededMaxForce = 0x0201;
inline constexpr Code kExceededMaxForceImpulse = 0x0202;
inline constexpr Code kExceededMaxVelocity = 0x0203;
inline constexpr Code kForceError = 0x0204;
inline constexpr Code kDeviceFault = 0x0300;
inline constexpr Code kDeviceAlreadyInitiated = 0x0301;
inline constexpr Code kCommError = 0x0302;
inline constexpr Code kCommConfigError = 0x0303;
inline constexpr Code kTimerError = 0x0304;
inline constexpr Code kIllegalBegin = 0x0400;
inline constexpr Code kIllegalEnd = 0x0401;
inline constexpr Code kFrameError = 0x0402;
inline constexpr Code kInvalidPriority = 0x0500;
inline constexpr Code kSchedulerFull = 0x0501;
inline constexpr Code kInvalidLicense = 0x0600;

}  // namespace palpate::hd
