// A library with the binary interface of Force Dimension's, written from its public documentation.
#include "tests/devices/forcedimension/fake_dhd.h"

#include <cmath>
#include <cstring>

namespace palpate::test {
namespace {

constexpr char kId = 0;
constexpr int kNoDeviceFound = 5;
constexpr int kInvalidIndex = 15;
constexpr int kNotEnabled = 19;

class Fake final : public FakeDhd {
 public:
  void Reset(const FakeDhdSetup& new_setup) override {
    *this = Fake();
    setup = new_setup;
    for (std::size_t i = 0; i < 3; ++i) rotation[i][i] = 1.0;
    status[dhd::kStatusPower] = status[dhd::kStatusConnected] = 1;
    status[dhd::kStatusStarted] = 1;
    status[dhd::kStatusReset] = !setup.calibrated;
    status[dhd::kStatusWristDetected] = status[dhd::kStatusWristInit] = setup.wrist;
    status[dhd::kStatusForce] = setup.calibrated && !setup.forces_wait;
    status[dhd::kStatusBrake] = !status[dhd::kStatusForce];
  }
  void Fail(const std::string& function, int nth, int code) override {
    failing_ = function;
    failing_in_ = nth;
    failing_code_ = code;
  }
  bool FailurePending() override { return failing_in_ > 0; }
  void TakeForce(int cause) override {
    status[dhd::kStatusForce] = 0;
    status[dhd::kStatusBrake] = 1;
    status[dhd::kStatusForceOffCause] = cause;
  }
  void GiveForce() override {
    status[dhd::kStatusForce] = 1;
    status[dhd::kStatusBrake] = 0;
  }
  double MotorForce() override {
    return status[dhd::kStatusForce] ? std::hypot(force_N[0], force_N[1], force_N[2]) : 0.0;
  }
  std::vector<std::string> Calls() override { return calls_; }
  std::vector<std::string> Violations() override { return violations_; }

  /// Called first by each function.  Negative: the answer with which the function returns at once.
  int Begin(const char* function, char id = kId, bool needs_arm = true) {
    calls_.push_back(function);
    if (needs_arm && (!open || id != kId)) {
      violations_.push_back(std::string(function) + " without an arm");
      return Refuse(kInvalidIndex);
    }
    if (failing_in_ > 0 && failing_ == function && --failing_in_ == 0) return Refuse(failing_code_);
    return 0;
  }
  int Refuse(int code) {
    error_ = code;
    return -1;
  }
  void Violation(const std::string& what) { violations_.push_back(what); }
  int error() const { return error_; }

 private:
  std::string failing_;
  int failing_in_ = 0;
  int failing_code_ = 0;
  int error_ = 0;
  std::vector<std::string> calls_, violations_;
};

Fake& TheFake() {
  static Fake fake;
  return fake;
}

int Open(const char* function, int serial) {
  if (const int failed = TheFake().Begin(function, 0, false)) return failed;
  if (TheFake().setup.arms == 0 || serial != TheFake().setup.serial) {
    return TheFake().Refuse(kNoDeviceFound);
  }
  TheFake().open = true;
  return kId;
}

/// A call that does `act` unless it is to fail, and then returns 0.
template <class Act>
int Do(const char* function, char id, Act act) {
  if (const int failed = TheFake().Begin(function, id)) return failed;
  act(TheFake());
  return 0;
}

int Give(const std::array<double, 3>& values, double* x, double* y, double* z) {
  *x = values[0];
  *y = values[1];
  *z = values[2];
  return TheFake().answer;
}

int Take(double fx, double fy, double fz, double tx, double ty, double tz) {
  for (const double value : {fx, fy, fz, tx, ty, tz}) {
    if (!std::isfinite(value)) TheFake().Violation("a force that is not a number");
  }
  TheFake().force_N = {fx, fy, fz};
  TheFake().torque_Nm = {tx, ty, tz};
  return TheFake().answer;
}

}  // namespace
}  // namespace palpate::test

using palpate::test::Do;
using palpate::test::Fake;
using palpate::test::FakeDhd;
using palpate::test::TheFake;
namespace dhd = palpate::dhd;

extern "C" {

FakeDhd* palpate_fake_dhd() {
  return &TheFake();
}

#define PALPATE_GIVES(result, name, parameters, value) \
  result name parameters {                             \
    return TheFake().value;                            \
  }
PALPATE_GIVES(int, dhdErrorGetLast, (), error())
PALPATE_GIVES(int, dhdGetDeviceCount, (), setup.arms)
PALPATE_GIVES(const char*, dhdGetSystemName, (char), setup.name.c_str())
PALPATE_GIVES(bool, dhdHasWrist, (char), setup.wrist)
PALPATE_GIVES(bool, dhdHasActiveWrist, (char), setup.active_wrist)
PALPATE_GIVES(bool, dhdHasActiveGripper, (char), setup.active_gripper)
PALPATE_GIVES(unsigned, dhdGetButtonMask, (char), buttons)
#undef PALPATE_GIVES

void dhdGetSDKVersion(int* major, int* minor, int* release, int* revision) {
  *major = 3;
  *minor = 17;
  *release = *revision = 1;
}
int dhdOpen() {
  return palpate::test::Open("dhdOpen", TheFake().setup.serial);
}
int dhdOpenSerial(int serial) {
  return palpate::test::Open("dhdOpenSerial", serial);
}
int dhdClose(char id) {
  return Do("dhdClose", id, [](Fake& fake) { fake.open = false; });
}
int dhdStop(char id) {
  return Do("dhdStop", id, [](Fake& fake) { fake.TakeForce(4); });
}
int dhdReset(char id) {
  return Do("dhdReset", id, [](Fake& fake) {
    fake.TakeForce(0);
    fake.status[dhd::kStatusReset] = 1;
  });
}
int dhdEnableForce(unsigned char on, char id) {
  if (const int failed = TheFake().Begin("dhdEnableForce", id)) return failed;
  if (!on) {
    TheFake().TakeForce(4);
  } else if (TheFake().status[dhd::kStatusReset]) {
    return TheFake().Refuse(palpate::test::kNotEnabled);
  } else {
    TheFake().GiveForce();
  }
  return 0;
}
int dhdSetGravityCompensation(int on, char id) {
  return Do("dhdSetGravityCompensation", id, [&](Fake& fake) { fake.gravity = on != 0; });
}
int dhdEmulateButton(unsigned char on, char id) {
  return Do("dhdEmulateButton", id, [&](Fake& fake) { fake.emulates_button = on != 0; });
}
int dhdGetSystemType(char id) {
  if (const int failed = TheFake().Begin("dhdGetSystemType", id)) return failed;
  return TheFake().setup.type;
}
int dhdGetSerialNumber(unsigned short* serial, char id) {
  return Do("dhdGetSerialNumber", id,
            [&](const Fake& fake) { *serial = static_cast<unsigned short>(fake.setup.serial); });
}
int dhdGetStatus(int* status, char id) {
  return Do("dhdGetStatus", id,
            [&](const Fake& fake) { std::memcpy(status, fake.status.data(), sizeof fake.status); });
}
int dhdGetPosition(double* x, double* y, double* z, char id) {
  if (const int failed = TheFake().Begin("dhdGetPosition", id)) return failed;
  return palpate::test::Give(TheFake().position_m, x, y, z);
}
int dhdGetPositionAndOrientationFrame(double* x, double* y, double* z, double matrix[3][3],
                                      char id) {
  if (const int failed = TheFake().Begin("dhdGetPositionAndOrientationFrame", id)) return failed;
  if (!TheFake().setup.wrist) TheFake().Violation("a rotation of an arm without a wrist");
  std::memcpy(matrix, TheFake().rotation.data(), sizeof TheFake().rotation);
  return palpate::test::Give(TheFake().position_m, x, y, z);
}
int dhdGetLinearVelocity(double* x, double* y, double* z, char id) {
  if (const int failed = TheFake().Begin("dhdGetLinearVelocity", id)) return failed;
  return palpate::test::Give(TheFake().velocity_m_s, x, y, z);
}
int dhdSetForce(double fx, double fy, double fz, char id) {
  if (const int failed = TheFake().Begin("dhdSetForce", id)) return failed;
  return palpate::test::Take(fx, fy, fz, 0.0, 0.0, 0.0);
}
int dhdSetForceAndTorque(double fx, double fy, double fz, double tx, double ty, double tz,
                         char id) {
  if (const int failed = TheFake().Begin("dhdSetForceAndTorque", id)) return failed;
  if (!TheFake().setup.active_wrist) TheFake().Violation("torque for an arm without its motors");
  return palpate::test::Take(fx, fy, fz, tx, ty, tz);
}

}  // extern "C"
