#pragma once

/// The binary interface of Force Dimension's DHD library (libdhd.so.3) on 64-bit Linux, in the
/// project's own words: no vendor header is needed to build, and the library is looked for at run
/// time (dhd_library.h).  The figures are those of the SDK's public documentation, 3.7 to 3.17.
/// Units of the library: m, m/s, rad, N, N m.  Matrices are row by row.  A device is named by its
/// number, `id`.  Most functions give a negative number where they fail, and
/// dhdErrorGetLast then has the code, for the thread that called.
namespace palpate::dhd {

// Those that the driver calls; the library has more.  X(result, name, arguments).
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

// Positive answers, which are no errors: everything from zero up is success.
inline constexpr int kTimeGuard = 1;       ///< asked again so soon that the arm was not read anew
inline constexpr int kMotorSaturated = 2;  ///< a motor could not give all of the force

/// What dhdGetStatus fills in, by place.  Releases since 3.7 know 16 or 17; room for later ones.
inline constexpr int kStatusRoom = 32;
enum StatusPlace {
  kStatusPower = 0,
  kStatusConnected = 1,
  kStatusStarted = 2,
  kStatusReset = 3,  ///< 1: it waits to be calibrated
  kStatusIdle = 4,
  kStatusForce = 5,  ///< 1: motors follow what is set
  kStatusBrake = 6,  ///< 1: motors are short-circuited: the arm is viscous and renders nothing
  kStatusWristDetected = 8,
  kStatusError = 9,
  kStatusWristInit = 12,
  kStatusForceOffCause = 14,
};

// dhdGetSystemType.
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
