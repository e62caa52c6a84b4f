#include "devices/openhaptics/hd_library.h"

#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
                               " is there, but needs libPHANToMIO.so, which is missing"));
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
  EXPECT_THAT(LibraryCandidates(), ElementsAre("/opt/hd/libHD.so"));
  unsetenv(kLibraryVariable);
  EXPECT_GT(LibraryCandidates().size(), 1u);
}

}  // namespace
}  // namespace palpate::hd
