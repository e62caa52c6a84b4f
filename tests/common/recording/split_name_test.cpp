#include "common/recording/split_name.h"

#include <gmock/gmock.h>

#include "common/error.h"
#include "tests/common/recording/samples.h"

namespace palpate::test {
namespace {

using testing::ElementsAre;

class SplitNameTest : public testing::Test {
 protected:
  std::vector<std::size_t> Numbers() const {
    std::vector<std::size_t> numbers;
    for (const NamedSplit& split : FindSplits(folder_ / "lesson.mcap")) {
      EXPECT_EQ(split.file, SplitName(folder_ / "lesson.mcap", split.number));
      numbers.push_back(split.number);
    }
    return numbers;
  }

  Folder folder_;
};

TEST_F(SplitNameTest, IsFoundAmongNamesThatAreLikeIt) {
  for (const char* name :
       {"lesson_000.mcap", "lesson_007.mcap", "lesson_1000.mcap", "lesson_20261122.mcap",
        "lesson_7.mcap", "lesson_0007.mcap", "lesson_07a.mcap", "lesson_-01.mcap", "lesson_.mcap",
        "lesson.mcap", "lesson_001.mcap.bak", "my_lesson_001.mcap", "lesson_100000.mcap"}) {
    WriteBytes(folder_ / name, {1});
  }
  EXPECT_THAT(Numbers(), ElementsAre(0, 7, 1000));
}

TEST_F(SplitNameTest, IsReplacedOnlyWhereARecordingStands) {
  RecordingWriter({.file = folder_ / "a.mcap"}).Close("");
  WriteBytes(folder_ / "thesis.pdf", {1, 2, 3});
  WriteBytes(folder_ / "empty.mcap", {});
  EXPECT_NO_THROW(CheckMayReplace(folder_ / "a.mcap"));
  EXPECT_NO_THROW(CheckMayReplace(folder_ / "none.mcap"));
  EXPECT_NO_THROW(CheckMayReplace(folder_ / "empty.mcap"));
  EXPECT_NO_THROW(CheckMayReplace("/dev/null"));
  EXPECT_THROW(CheckMayReplace(folder_ / "thesis.pdf"), Error);
  EXPECT_THROW(CheckMayReplace(folder_ / "."), Error);
  // Named by somebody else's recorder.
  { mcap::Writer other(folder_ / "other.mcap", "another program"); }
  EXPECT_THROW(CheckMayReplace(folder_ / "other.mcap"), Error);
}

}  // namespace
}  // namespace palpate::test
