#include "client/replayer/play/bookmarks.h"

#include <filesystem>
#include <utility>

#include <gmock/gmock.h>

#include "tests/common/recording/samples.h"
#include "tests/support/complaint.h"
#include "tests/support/read_file.h"

namespace palpate::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<std::pair<double, std::string>> NamesOf(const Bookmarks& bookmarks) {
  std::vector<std::pair<double, std::string>> names;
  for (const Bookmarks::Bookmark& bookmark : bookmarks.all()) {
    names.emplace_back(bookmark.at_s, bookmark.name);
  }
  return names;
}

void WriteText(const std::string& file, const std::string& text) {
  WriteBytes(file, {text.begin(), text.end()});
}

class BookmarksTest : public testing::Test {
 protected:
  Folder folder_;
  std::string file_ = folder_ / "lesson.bookmarks.json";
};

TEST_F(BookmarksTest, StandBesideTheRecording) {
  EXPECT_EQ(Bookmarks::FileFor("a/lesson.mcap"), "a/lesson.bookmarks.json");
  EXPECT_EQ(Bookmarks::FileFor("a/lesson"), "a/lesson.bookmarks.json");
}

TEST_F(BookmarksTest, AreKeptByTime) {
  {
    Bookmarks bookmarks(file_);
    EXPECT_THAT(bookmarks.all(), IsEmpty());
    EXPECT_FALSE(std::filesystem::exists(file_)) << "who only looks writes nothing";
    bookmarks.Add(7.25, "  the groove\tagain ");
    bookmarks.Add(0.1, "Öffnen, \"zuerst\"");
    bookmarks.Add(3.0, "gone soon");
    bookmarks.Drop(bookmarks.all()[1].number);
  }
  Bookmarks bookmarks(file_);
  EXPECT_THAT(NamesOf(bookmarks), ElementsAre(std::pair(0.1, "Öffnen, \"zuerst\""),
                                              std::pair(7.25, "the groove again")));
  bookmarks.Add(0.1, "after the former of that time");
  EXPECT_EQ(bookmarks.all()[1].name, "after the former of that time");
  EXPECT_NE(bookmarks.all()[0].number, bookmarks.all()[1].number);
}

TEST_F(BookmarksTest, RefuseWhatTheyCouldNotReadBack) {
  Bookmarks bookmarks(file_);
  EXPECT_THAT(ComplaintOf([&] { bookmarks.Add(1.0, ""); }), HasSubstr("needs a name"));
  EXPECT_THAT(ComplaintOf([&] { bookmarks.Add(1.0, " \n\t "); }), HasSubstr("needs a name"));
  EXPECT_THAT(ComplaintOf([&] { bookmarks.Add(1.0, std::string(101, 'a')); }),
              HasSubstr("shorten"));
  EXPECT_THAT(ComplaintOf([&] { bookmarks.Add(1.0, "a\xff"); }), HasSubstr("UTF-8"));
  EXPECT_THAT(ComplaintOf([&] { bookmarks.Add(std::nan(""), "a"); }), HasSubstr("no such time"));
  EXPECT_THAT(ComplaintOf([&] { bookmarks.Add(-1.0, "a"); }), HasSubstr("no such time"));
  EXPECT_THAT(ComplaintOf([&] { bookmarks.Drop(1); }), HasSubstr("no longer exists"));
  EXPECT_FALSE(std::filesystem::exists(file_));
  for (std::size_t i = 0; i < Bookmarks::kMost; ++i) bookmarks.Add(1.0, "a");
  EXPECT_THAT(ComplaintOf([&] { bookmarks.Add(1.0, "a"); }), HasSubstr("drop one first"));
  EXPECT_EQ(Bookmarks(file_).all().size(), Bookmarks::kMost);
}

TEST_F(BookmarksTest, SayWhatIsWrongWithAFileAndLeaveItAsItIs) {
  const std::vector<std::pair<std::string, std::string>> files = {
      {"", "lesson.bookmarks.json:"},
      {"not JSON at all", "lesson.bookmarks.json:1"},
      {"{\"bookmarks\": [", "lesson.bookmarks.json:"},
      {"[1, 2]", "an object"},
      {"{}", "bookmarks"},
      {"{\"notes\": []}", "no such field"},
      {"{\"bookmarks\": 3}", "bookmarks"},
      {"{\"bookmarks\": [\n {\"at_s\": \"one\", \"name\": \"a\"}]}", "bookmarks[0].at_s"},
      {"{\"bookmarks\": [\n {\"at_s\": -1, \"name\": \"a\"}]}", ":2: bookmarks[0].at_s"},
      {"{\"bookmarks\": [\n {\"at_s\": 1, \"name\": \" \"}]}", ":2: bookmarks[0].name"},
      {"{\"bookmarks\": [\n {\"at_s\": 1}]}", "name"},
      {"{\"bookmarks\": [\n {\"at_s\": 1, \"name\": \"a\", \"by\": 2}]}", "no such field"}};
  for (const auto& [text, complaint] : files) {
    SCOPED_TRACE(text);
    WriteText(file_, text);
    EXPECT_THAT(ComplaintOf([&] { Bookmarks{file_}; }), HasSubstr(complaint));
    EXPECT_EQ(ReadWholeFile(file_), text);
  }
}

TEST_F(BookmarksTest, DoNotWriteOverWhatAnotherHasWrittenMeanwhile) {
  Bookmarks first(file_), second(file_);
  first.Add(1.0, "the first's");
  EXPECT_THAT(ComplaintOf([&] { second.Add(2.0, "the second's"); }),
              HasSubstr("was changed by another program"));
  EXPECT_THAT(second.all(), IsEmpty());
  EXPECT_THAT(NamesOf(Bookmarks(file_)), ElementsAre(std::pair(1.0, "the first's")));
  first.Add(3.0, "and one more");
  EXPECT_EQ(Bookmarks(file_).all().size(), 2u);
}

TEST_F(BookmarksTest, AreAsBeforeWhereTheyCannotBeWritten) {
  Bookmarks bookmarks(folder_ / "gone/lesson.bookmarks.json");
  EXPECT_THAT(ComplaintOf([&] { bookmarks.Add(1.0, "a"); }), HasSubstr("cannot be written"));
  EXPECT_THAT(bookmarks.all(), IsEmpty());
}

}  // namespace
}  // namespace palpate::test
