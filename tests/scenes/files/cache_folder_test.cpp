#include "scenes/files/cache_folder.h"

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/error.h"
#include "tests/scenes/support.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr uid_t kStranger = 54321;

TEST(CacheFolder, IsMadeForItsUserAlone) {
  const std::string folder = FreshFolder();
  const std::string cache = folder + "/a/b/palpate";
  PrepareCacheFolder(cache);
  struct stat status {};
  ASSERT_EQ(stat(cache.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 07777u, 0700u);
  EXPECT_EQ(status.st_uid, geteuid());
  EXPECT_NO_THROW(PrepareCacheFolder(cache)) << "that is there";
}

TEST(CacheFolder, IsNotTakenWhereOthersMayWriteToIt) {
  const std::string folder = FreshFolder();
  for (const mode_t mode : {01777u, 0777u, 0775u, 0702u}) {
    const std::string cache = folder + "/" + std::to_string(mode);
    std::filesystem::create_directory(cache);
    ASSERT_EQ(chmod(cache.c_str(), mode), 0);
    EXPECT_THAT([&] { PrepareCacheFolder(cache); },
                ThrowsMessage<Error>(HasSubstr(cache + ": others can write to it")));
  }
}

TEST(CacheFolder, IsNotTakenWhereItIsAnothers) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can give a folder to another user";
  const std::string folder = FreshFolder();
  const std::string cache = folder + "/palpate", file = folder + "/scene.palpate";
  std::filesystem::create_directory(cache);
  WriteFile(file, "x");
  EXPECT_TRUE(IsOwnFile(file));
  ASSERT_EQ(chown(cache.c_str(), kStranger, kStranger), 0);
  ASSERT_EQ(chown(file.c_str(), kStranger, kStranger), 0);
  EXPECT_THAT([&] { PrepareCacheFolder(cache); },
              ThrowsMessage<Error>(HasSubstr(cache + ": belongs to another user")));
  EXPECT_FALSE(IsOwnFile(file));
}

TEST(CacheFolder, HoldsNoLinks) {
  const std::string folder = FreshFolder();
  WriteFile(folder + "/a", "x");
  std::filesystem::create_symlink(folder + "/a", folder + "/link");
  EXPECT_TRUE(IsOwnFile(folder + "/a"));
  EXPECT_FALSE(IsOwnFile(folder + "/link"));
  EXPECT_FALSE(IsOwnFile(folder + "/none"));
}

TEST(CacheFolder, NamesWhatStandsInItsPlace) {
  const std::string folder = FreshFolder();
  WriteFile(folder + "/palpate", "x");
  EXPECT_THAT([&] { PrepareCacheFolder(folder + "/palpate"); },
              ThrowsMessage<Error>(HasSubstr("is not a folder")));
  EXPECT_THROW(PrepareCacheFolder(folder + "/palpate/below"), Error);
}

}  // namespace
}  // namespace palpate::test
