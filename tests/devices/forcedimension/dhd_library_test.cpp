#include "devices/forcedimension/dhd_library.h"

#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/complaint.h"

namespace palpate::dhd {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

std::string LoadError(const std::vector<std::string>& candidates) {
  return test::ComplaintOf([&] { LoadLibrary(candidates); });
}

TEST(DhdLibrary, BindsEveryFunction) {
  const Library library = LoadLibrary({"libno-such-dhd.so", PALPATE_FAKE_DHD});
  EXPECT_EQ(library.file, PALPATE_FAKE_DHD);
#define PALPATE_DHD_LOOK(result, name, arguments) \
  EXPECT_NE(library.functions.name, nullptr) << #name;
  PALPATE_DHD_FUNCTIONS(PALPATE_DHD_LOOK)
#undef PALPATE_DHD_LOOK
}

TEST(DhdLibrary, SaysWhatToInstallWhereThereIsNoneOrItIsAnother) {
  EXPECT_THAT(LoadError({"libno-such-dhd.so"}),
              AllOf(HasSubstr("forcedimension: no DHD library could be loaded"),
                    HasSubstr("install Force Dimension's SDK"), HasSubstr(kLibraryVariable)));
  EXPECT_THAT(LoadError({"libm.so.6"}),
              AllOf(HasSubstr("libm.so.6 has no dhdErrorGetLast, "),
                    HasSubstr("it is not Force Dimension's DHD library")));
}

TEST(DhdLibrary, TriesTheFileThatTheVariableNamesAlone) {
  setenv(kLibraryVariable, "/opt/sdk/libdhd.so.3", 1);
  EXPECT_THAT(LibraryCandidates(), ElementsAre("/opt/sdk/libdhd.so.3"));
  unsetenv(kLibraryVariable);
  EXPECT_THAT(LibraryCandidates(), ElementsAre("libdhd.so.3", "libdhd.so"));
}

}  // namespace
}  // namespace palpate::dhd
