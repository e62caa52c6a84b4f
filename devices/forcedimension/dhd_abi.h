#pragma once

/// The binary interface of Force Dimension's DHD library (libdhd.so.3) on 64-bit Linux, declared by
/// the project itself: building needs no vendor header, and the library is loaded at run time
/// (dhd_library.h).  The values are those of the SDK's public documentation, 3.7 to 3.17. Units of
/// the library: m, m/s, rad, N, N m.  Matrices are row-major.  A device is identified by its
/// number, `id`.  Most functions return a negative number if they fail; dhdErrorGetLast then has
/// the code, for the calling thread.
namespace palpate::dhd {

// The functions that the driver calls; the library has more.  X(result, name, arguments).
#define PALPATE_DHD_FUNCTIONS(X)                                                   \
  X(int, dhdErrorGetLast, (void))                                                  \
  X(void, dhdGetSDKVersion, (int* major, int* minor, int* release, int* revision)) \
  X(int, dhdGetDeviceCount, (void))                                                \
  X(int, dhdOpen, (void))                                                          \
  X(int, dhdOpenSerial, (int serial))                                              \
  X(int, dhdClose, (char id))                                                      \
  X(int, dhdStop, (char id))                                                       \
  X(int, dhdReset, (char id))                                                      \
  X(int, dhdEnableForce, (unsigned char on, char id))                              \
  X(int, dhdSetGravityCompensation, (int on, char id))                             \
  X(int, dhdEmulateButton, (unsigned char on, char id))                            \
  X(int, dhdGetSystemType, (char id))                                              \
  X(const char*, dhdGetSystemName, (char id))                                      \
  X(int, dhdGetSerialNumber, (unsigned short* serial, char id))                    \
  X(bool, dhdHasWrist, (char id))                                                  \
  X(bool, dhdHasActiveWrist, (char id))                                            \
  X(bool, dhdHasActiveGripper, (char id))                                          \
  X(int, dhdGetStatus, (int* status, char id))                                     \
  X(unsigned int, dhdGetButtonMask, (char id))                                     \
  X(int, dhdGetPosition, (double* x, double* y, double* z, char id))               \
  X(int, dhdGetPositionAndOrientationFrame,                                        \
    (double* x, double* y, double* z, double matrix[3][3], char id))               \
  X(int, dhdGetLinearVelocity, (double* x, double* y, double* z, char id))         \
  X(int, dhdSetForce, (double fx, double fy, double fz, char id))                  \
  X(int, dhdSetForceAndTorque,                                                     \
    (double fx, double fy, double fz, double tx, double ty, double tz, char id))

/// The library's functions, by their own names.
struct Functions {
#define PALPATE_DHD_MEMBER(result, name, arguments) result(*name) arguments = nullptr;
  PALPATE_DHD_FUNCTIONS(PALPATE_DHD_MEMBER)
#undef PALPATE_DHD_MEMBER

  template <class Visit>
  void ForEach(Visit visit) {
#define PALPATE_DHD_VISIT(result, name, arguments) visit(name, #name);
    PALPATE_DHD_FUNCTIONS(PALPATE_DHD_VISIT)
#undef PALPATE_DHD_VISIT
  }
};

inline constexpr unsigned char kOn = 1;
inline constexpr unsigned char kOff = 0;

// Positive return values.  They are no errors: zero and above mean success.
inline constexpr int kTimeGuard = 1;       ///< called again so soon that the arm was not read anew
inline constexpr int kMotorSaturated = 2;  ///< a motor could not give all of the force

/// Size of dhdGetStatus's array, with room for later releases: those since 3.7 have 16 or
/// 17 values.
inline constexpr int kStatusRoom = 32;
enum StatusPlace {
  kStatusPower = 0,
  kStatusConnected = 1,
  kStatusStarted = 2,
  kStatusReset = 3,  ///< 1: the arm waits for calibration
  kStatusIdle = 4,
  kStatusForce = 5,  ///< 1: the motors render the force that is set
  kStatusBrake = 6,  ///< 1: the motors are short-circuited: the arm is viscous and renders no force
  kStatusWristDetected = 8,
  kStatusError = 9,
  kStatusWristInit = 12,
  kStatusForceOffCause = 14,
};

// Return values of dhdGetSystemType.
inline constexpr int kOmega3 = 33;
inline constexpr int kOmega6 = 34;
inline constexpr int kOmega7 = 35;
inline constexpr int kOmega6Left = 36;
inline constexpr int kOmega7Left = 37;
inline constexpr int kFalcon = 60;
inline constexpr int kDelta3 = 63;
inline constexpr int kDelta6 = 64;
inline constexpr int kSigma7 = 104;
inline constexpr int kSigma7Left = 105;
inline constexpr int kSigma6Plus = 106;
inline constexpr int kSigma6PlusLeft = 107;
inline constexpr int kLambda7 = 108;
inline constexpr int kLambda7Left = 109;
inline constexpr int kLambda3 = 203;
inline constexpr int kSigma3 = 206;

}  // namespace palpate::dhd
