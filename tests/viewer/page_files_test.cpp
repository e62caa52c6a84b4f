#include "client/viewer/page_files.h"

#include <fstream>

#include <gmock/gmock.h>

#include "tests/support/folder.h"
#include "tests/support/random.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;
using test::Random;

class PageFilesTest : public testing::Test {
 protected:
  PageFilesTest() {
    fs::create_directories(folder_ / "page/assets");
    Write("secret.js");
    Write("page/index.html");
    Write("page/assets/a.js");
    Write("page/assets/a.js.gz");
    Write("page/only.css.gz");
    fs::create_symlink(folder_ / "secret.js", folder_ / "page/link.js");
    fs::create_symlink(folder_, folder_ / "page/up");
  }
  void Write(const std::string& name) { std::ofstream(folder_ / name) << name; }

  const test::Folder kept_;
  const fs::path folder_ = kept_.path();
  PageFiles files_{folder_ / "page/../page"};
};

TEST(PathOfTarget, IsWithoutQueryAndEscapes) {
  EXPECT_EQ(PathOfTarget("/a%20b.js?x=../y#z"), "/a b.js");
  EXPECT_EQ(PathOfTarget("/"), "/");
  EXPECT_EQ(PathOfTarget("/..a/b..c/..."), "/..a/b..c/...");
}

TEST(PathOfTarget, IsNoneThatClimbsOrLies) {
  for (const char* target :
       {"", "a", "http://x/", "/..", "/../a", "/a/../b", "/a/..", "/%2e%2e/a", "/%2E./a", "/..%2fa",
        "/a%00b", "/a\\..\\b", "/%5c", "/%", "/%2", "/%zz", "/%-1", "*"}) {
    EXPECT_EQ(PathOfTarget(target), std::nullopt) << target;
  }
}

TEST(AcceptsGzip, UnlessItIsAbsentOrRefused) {
  for (const char* yes : {"gzip", "deflate, gzip;q=0.5, *", "gzip;q=1.0,br"}) {
    EXPECT_TRUE(AcceptsGzip(yes)) << yes;
  }
  for (const char* no : {"", "br", "identity", "gzip;q=0", "gzip;q=0.000, br"}) {
    EXPECT_FALSE(AcceptsGzip(no)) << no;
  }
}

TEST_F(PageFilesTest, GivesFilesWithTheirTypes) {
  EXPECT_TRUE(files_.built());
  const auto index = files_.Find("/", true);
  ASSERT_TRUE(index);
  EXPECT_EQ(index->path.filename(), "index.html");
  EXPECT_THAT(index->content_type, testing::StartsWith("text/html"));
  EXPECT_FALSE(index->gzip);
  EXPECT_FALSE(index->hashed);
  const auto packed = files_.Find("/assets/a.js", true);
  ASSERT_TRUE(packed);
  EXPECT_EQ(packed->path.filename(), "a.js.gz");
  EXPECT_TRUE(packed->gzip);
  EXPECT_TRUE(packed->hashed);
  EXPECT_THAT(packed->content_type, testing::StartsWith("text/javascript"));
  EXPECT_EQ(files_.Find("/assets/a.js", false)->path.filename(), "a.js");
  EXPECT_FALSE(files_.Find("/only.css", false));
  const auto content = files_.Read(*packed);
  EXPECT_EQ(*content, "page/assets/a.js.gz");
  EXPECT_EQ(files_.Read(*packed), content) << "one copy, whoever is sent it";
}

TEST_F(PageFilesTest, GivesNothingFromOutsideItsFolder) {
  for (const char* path : {"/link.js", "/up/secret.js", "/../secret.js", "/assets", "/assets/",
                           "/nothing", "//etc/passwd", "/up/page/../secret.js"}) {
    EXPECT_FALSE(files_.Find(path, false)) << path;
  }
  EXPECT_FALSE(PageFiles("/no/such/folder").built());
}

TEST_F(PageFilesTest, GivesNothingFromOutsideItsFolderForAnyTarget) {
  Random random(6);
  const char* pieces[] = {"/",   "..",     ".",       "%2e",        "%2f",       "a.js",
                          "up",  "assets", "link.js", "index.html", "secret.js", "page",
                          "%00", "\\",     "//",      "?",          "%"};
  int found = 0;
  for (int i = 0; i < 30'000; ++i) {
    std::string target = "/";
    for (std::size_t n = random.Below(7); n > 0; --n)
      target += pieces[random.Below(std::size(pieces))];
    const auto path = PathOfTarget(target);
    if (!path) continue;
    const auto file = files_.Find(*path, random.Below(2) == 0);
    if (!file) continue;
    ++found;
    ASSERT_THAT(file->path.string(),
                testing::StartsWith(fs::canonical(folder_ / "page").string() + "/"))
        << target;
  }
  EXPECT_GT(found, 100);
}

TEST_F(PageFilesTest, GiveNothingOfAFolderToWhichALinkLeads) {
  PageFile file{folder_ / "page/link.js", "text/javascript"};
  EXPECT_NE(files_.Read(file), nullptr);
  file = {folder_ / "page/up/secret.js", "text/javascript"};
  file.below = folder_ / "page";
  EXPECT_EQ(files_.Read(file), nullptr);
  file.path = folder_ / "page/assets/a.js";
  EXPECT_NE(files_.Read(file), nullptr);
}

}  // namespace
}  // namespace palpate
