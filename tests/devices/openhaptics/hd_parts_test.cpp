#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <set>
#include <string>
#include <type_traits>
#include <vector>

#include <gmock/gmock.h>

#include "devices/openhaptics/device_nodes.h"
#include "devices/openhaptics/hd_abi.h"
#include "devices/openhaptics/hd_error.h"
#include "devices/openhaptics/hd_library.h"
#include "devices/openhaptics/output_gate.h"
#include "tests/support/complaint.h"

namespace palpate::hd {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

std::string LoadError(const std::vector<std::string>& candidates) {
  return test::ComplaintOf([&] { LoadLibrary(candidates); });
}

TEST(HdLibrary, BindsEveryFunctionOfTheFirstOneThatThereIs) {
  const Library library = LoadLibrary({"libno-such-hd.so", PALPATE_FAKE_HD, PALPATE_NO_LIBRARY});
  EXPECT_EQ(library.file, PALPATE_FAKE_HD);
  int functions = 0;
#define PALPATE_HD_COUNT(result, name, arguments) \
  ++functions;                                    \
  EXPECT_NE(library.functions.name, nullptr) << #name;
  PALPATE_HD_FUNCTIONS(PALPATE_HD_COUNT)
#undef PALPATE_HD_COUNT
  EXPECT_EQ(functions, 22);
}

TEST(HdLibrary, NamesAllThatWasTriedWhereThereIsNone) {
  const std::string error = LoadError({"libno-such-hd.so", "libno-such-hd.so.3"});
  EXPECT_THAT(error, HasSubstr("Tried: libno-such-hd.so: libno-such-hd.so: cannot open"));
  EXPECT_THAT(error, HasSubstr("; libno-such-hd.so.3: "));
  EXPECT_THAT(error, HasSubstr("install OpenHaptics"));
  EXPECT_THAT(error, HasSubstr(kLibraryVariable));
}

TEST(HdLibrary, PassesOnWhatTheLoaderSaysOfAFileThatIsNoLibrary) {
  EXPECT_THAT(LoadError({PALPATE_NO_LIBRARY}), HasSubstr("file too short"));
}

TEST(HdLibrary, NamesTheLibraryThatItNeedsAndThatIsMissing) {
  const std::string error = LoadError({PALPATE_FAKE_HD_NEEDING, PALPATE_FAKE_HD});
  EXPECT_THAT(error, HasSubstr(std::string(PALPATE_FAKE_HD_NEEDING) +
                               " exists, but needs libPHANToMIO.so, which is missing"));
  EXPECT_THAT(error, HasSubstr("it comes with the arm's driver"));
}

TEST(HdLibrary, NamesTheFunctionsThatAreMissing) {
  const std::string error = LoadError({PALPATE_FAKE_MIO});
  EXPECT_THAT(error, HasSubstr(PALPATE_FAKE_MIO " has no hdMakeCurrentDevice, hdDisableDevice"));
  EXPECT_THAT(error, Not(HasSubstr("hdInitDevice")));
  EXPECT_THAT(error, HasSubstr("install 3.0 or later"));
}

TEST(HdLibrary, TriesTheFileThatTheVariableNamesAlone) {
  setenv(kLibraryVariable, "/opt/hd/libHD.so", 1);
  EXPECT_THAT(kLibraryWords.Candidates(), ElementsAre("/opt/hd/libHD.so"));
  unsetenv(kLibraryVariable);
  EXPECT_GT(kLibraryWords.Candidates().size(), 1u);
}

static_assert(sizeof(Handle) == 4 && sizeof(SchedulerHandle) == 8 && sizeof(long) == 8);
static_assert(sizeof(ErrorInfo) == 12 && std::is_trivially_copyable_v<ErrorInfo>);

// The figures once more, from the public documentation and not from the header, so that a typing
// error in either shows.
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

TEST(HdError, NamesEveryCodeOnceAndHasARemedyForIt) {
  std::set<Code> codes;
  std::set<std::string> names;
  for (const ErrorText& text : ErrorTexts()) {
    EXPECT_TRUE(codes.insert(text.code).second) << text.name;
    EXPECT_TRUE(names.insert(text.name).second) << text.name;
    EXPECT_GT(std::string(text.remedy).size(), 10u) << text.name;
    EXPECT_THAT(Describe({text.code, 7, 0}), HasSubstr(text.name));
    EXPECT_THAT(Describe({text.code, 7, 0}), HasSubstr(text.remedy));
  }
  EXPECT_EQ(codes.size(), 22u);
}

TEST(HdError, DropsContactForTooMuchForceAndLatchesForWhatIsBrokenOrUnknown) {
  // The vendor's own helper does not count the impulse among the force errors.
  for (const Code code :
       {kExceededMaxForce, kExceededMaxForceImpulse, kExceededMaxVelocity, kForceError}) {
    EXPECT_EQ(ClassOf(code), ErrorClass::kForce) << code;
  }
  EXPECT_EQ(ClassOf(kWarmMotors), ErrorClass::kWarm);
  for (const Code code : {kDeviceFault, kCommError, kCommConfigError, kTimerError}) {
    EXPECT_EQ(ClassOf(code), ErrorClass::kFatal) << code;
  }
  EXPECT_EQ(ClassOf(kSuccess), ErrorClass::kNone);
  EXPECT_EQ(ClassOf(0x999), ErrorClass::kUse);
  EXPECT_THAT(Describe({0x999, 3, 0}), HasSubstr("an unknown error (0x999, internal 3)"));
}

class DeviceNodes : public testing::Test {
 protected:
  DeviceNodes() {
    std::string pattern = testing::TempDir() + "palpate-nodes-XXXXXX";
    folder = mkdtemp(pattern.data());
  }
  ~DeviceNodes() override { std::filesystem::remove_all(folder); }
  void Add(const std::string& name) { std::ofstream(folder + "/" + name) << "."; }
  std::string folder;
};

TEST_F(DeviceNodes, SayThatNothingIsPluggedIn) {
  Add("tty0");
  EXPECT_THAT(DescribeDeviceNodes(folder), HasSubstr("no arm is plugged in"));
  EXPECT_THAT(DescribeDeviceNodes(folder + "/none"), HasSubstr("no arm is plugged in"));
}

TEST_F(DeviceNodes, NameThoseThatTheUserMayNotOpen) {
  Add("ttyACM0");
  Add("fw0");
  const std::string text =
      DescribeDeviceNodes(folder, [](const std::string& node) { return node.ends_with("fw0"); });
  EXPECT_THAT(text, HasSubstr("may not open " + folder + "/ttyACM0: add it to the group"));
  EXPECT_THAT(DescribeDeviceNodes(folder),
              HasSubstr("may be opened: " + folder + "/fw0 " + folder + "/ttyACM0"));
}

using State = OutputGate::State;

const Wrench kNothing{};
const Wrench kForce{Vec3(0, 1, 0), Vec3::Zero()};

OutputGate OpenGate() {
  OutputGate gate(1000.0);
  gate.Open();
  for (int i = 0; i < 200; ++i) gate.Passes(kNothing);
  EXPECT_EQ(gate.state(), State::kOn);
  return gate;
}

TEST(OutputGate, IsClosedUntilTheArmIsCalibratedAndNothingIsAskedFor) {
  OutputGate gate(1000.0);
  for (int i = 0; i < 1000; ++i) EXPECT_FALSE(gate.Passes(kNothing));
  gate.Open();
  for (int i = 0; i < 1000; ++i) EXPECT_FALSE(gate.Passes(kForce)) << "that would be a step";
  EXPECT_TRUE(gate.Passes(kNothing));
  EXPECT_TRUE(gate.Passes(kForce));
}

TEST(OutputGate, PausesForATooGreatForceUntilTenthOfASecondIsQuiet) {
  OutputGate gate = OpenGate();
  gate.Report(ErrorClass::kForce);
  EXPECT_TRUE(gate.motors_on());
  for (int i = 1; i < 100; ++i) EXPECT_FALSE(gate.Passes(kNothing)) << i;
  gate.Report(ErrorClass::kForce);
  for (int i = 1; i < 100; ++i) EXPECT_FALSE(gate.Passes(kNothing)) << i;
  EXPECT_TRUE(gate.Passes(kNothing));
}

TEST(OutputGate, TurnsTheMotorsOffUntilTheyAreCool) {
  OutputGate gate = OpenGate();
  gate.SetTemperature(0.95);
  gate.Report(ErrorClass::kWarm);
  EXPECT_FALSE(gate.motors_on());
  for (int i = 0; i < 5000; ++i) EXPECT_FALSE(gate.Passes(kNothing));
  gate.SetTemperature(std::numeric_limits<double>::quiet_NaN());
  for (int i = 0; i < 5000; ++i) EXPECT_FALSE(gate.Passes(kNothing));
  gate.SetTemperature(0.69);
  EXPECT_FALSE(gate.Passes(kNothing));
  EXPECT_EQ(gate.state(), State::kPaused);
  for (int i = 0; i < 99; ++i) EXPECT_FALSE(gate.Passes(kNothing));
  EXPECT_TRUE(gate.Passes(kNothing));
}

TEST(OutputGate, RestsTwoSecondsEvenWhereTheMotorsSeemCoolAndAMinuteWhereNobodyKnows) {
  OutputGate gate = OpenGate();
  gate.SetTemperature(0.1);
  gate.Report(ErrorClass::kWarm);
  for (int i = 1; i < 2000; ++i) gate.Passes(kNothing);
  EXPECT_EQ(gate.state(), State::kCooling);
  gate.Passes(kNothing);
  EXPECT_EQ(gate.state(), State::kPaused);

  OutputGate blind = OpenGate();
  blind.Report(ErrorClass::kWarm);
  for (int i = 1; i < 60000; ++i) blind.Passes(kNothing);
  EXPECT_EQ(blind.state(), State::kCooling);
  blind.Passes(kNothing);
  EXPECT_EQ(blind.state(), State::kPaused);
}

TEST(OutputGate, LatchesWhateverComesAfterwards) {
  for (const ErrorClass worst : {ErrorClass::kFatal, ErrorClass::kUse}) {
    OutputGate gate = OpenGate();
    gate.Report(worst);
    gate.Report(ErrorClass::kWarm);
    gate.Report(ErrorClass::kForce);
    gate.Open();
    for (int i = 0; i < 100'000; ++i) EXPECT_FALSE(gate.Passes(kNothing));
    EXPECT_FALSE(gate.motors_on());
    EXPECT_EQ(gate.state(), State::kLatched);
  }
}

TEST(OutputGate, IsNotOpenedByAnErrorWhileTheArmIsCalibrated) {
  for (const ErrorClass error : {ErrorClass::kNone, ErrorClass::kForce, ErrorClass::kWarm}) {
    OutputGate gate(1000.0);
    gate.Report(error);
    for (int i = 0; i < 100'000; ++i) EXPECT_FALSE(gate.Passes(kNothing));
    EXPECT_FALSE(gate.motors_on());
  }
}

}  // namespace
}  // namespace palpate::hd
