#include "client/course/seal.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <sys/stat.h>

#include "common/files/whole_file.h"
#include "tests/support/complaint.h"
#include "tests/support/folder.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

Seal AnExample() {
  Seal seal;
  seal.recording = "trials/3/light-force/1.mcap";
  seal.person = 3;
  seal.name = "王伟";
  seal.exam = "midterm";
  seal.task = 1;
  return seal;
}

SealKey PublicOf(const Folder& folder) {
  return SealKey::ReadPublic(folder / SealKey::kPublicFile);
}

TEST(Sha256, IsThatOfFips180) {
  EXPECT_EQ(Sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  const Folder folder;
  std::ofstream(folder / "a") << "abc";
  EXPECT_EQ(Sha256OfFile(folder / "a").sha256, Sha256("abc"));
  EXPECT_EQ(Sha256OfFile(folder / "a").bytes, 3);
}

TEST(SealKey, IsMadeOnceForItsOwnerAloneAndIsRefusedWhereOthersMayReadIt) {
  const Folder folder;
  const std::string file = folder / SealKey::kFile;
  const std::string name = SealKey::OfCourse(folder.path()).name();
  EXPECT_EQ(SealKey::OfCourse(folder.path()).name(), name);
  EXPECT_EQ(PublicOf(folder).name(), name);
  struct stat status {};
  ASSERT_EQ(stat(file.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 07777, 0600u);
  EXPECT_THAT(ComplaintOf([&] { SealKey::ReadPublic(file); }), HasSubstr("exam-key.pub.pem"));
  std::filesystem::permissions(file, std::filesystem::perms(0644));
  EXPECT_THAT(ComplaintOf([&] { SealKey::OfCourse(folder.path()); }), HasSubstr("chmod 0600"));
  std::filesystem::permissions(file, std::filesystem::perms(0600));
  std::ofstream(file) << "no key";
  EXPECT_THAT(ComplaintOf([&] { SealKey::OfCourse(folder.path()); }),
              HasSubstr("is not an Ed25519"));
}

TEST(SealKey, IsNeitherReadNorWrittenThroughALink) {
  namespace fs = std::filesystem;
  const Folder folder, elsewhere;
  std::ofstream(elsewhere / "victim") << "another's";
  fs::create_symlink(elsewhere / "victim", folder / SealKey::kPublicFile);
  const std::string name = SealKey::OfCourse(folder.path()).name();
  EXPECT_EQ(ReadWholeFile(elsewhere / "victim", 100), "another's");
  EXPECT_EQ(PublicOf(folder).name(), name);
  fs::rename(folder / SealKey::kFile, elsewhere / "key");
  fs::create_symlink(elsewhere / "key", folder / SealKey::kFile);
  EXPECT_THAT(ComplaintOf([&] { SealKey::OfCourse(folder.path()); }), HasSubstr("is a link"));
}

TEST(Seal, SaysWhatWasSealedWhereNoByteOfItHasChanged) {
  const Folder folder;
  const SealKey key = SealKey::OfCourse(folder.path());
  const SealKey open = PublicOf(folder);
  const std::string text = SealText(AnExample(), key);
  EXPECT_EQ(OpenSeal(text, open, "it").name, "王伟");
  // One bit of each byte, including those that JSON or hexadecimal digits would read the same.
  for (std::size_t i = 0; i < text.size(); ++i) {
    std::string spoilt = text;
    spoilt[i] = static_cast<char>(spoilt[i] ^ (1 << (i % 8)));
    EXPECT_THAT(ComplaintOf([&] { OpenSeal(spoilt, open, "it"); }), HasSubstr("changed")) << i;
  }
  for (const std::string& other :
       {text.substr(0, text.size() - 1), " " + text, text + "\n", text + text}) {
    EXPECT_THAT(ComplaintOf([&] { OpenSeal(other, key, "it"); }), HasSubstr("changed"));
  }
}

TEST(Seal, OfAnotherKeyOrFormatIsRefusedWithTheReason) {
  const Folder folder, other;
  const SealKey key = SealKey::OfCourse(folder.path());
  const std::string text = SealText(AnExample(), SealKey::OfCourse(other.path()));
  EXPECT_THAT(ComplaintOf([&] { OpenSeal(text, key, "it"); }), HasSubstr("another course's"));
  Seal newer = AnExample();
  newer.format = "palpate-seal-3";
  EXPECT_THAT(ComplaintOf([&] { OpenSeal(SealText(newer, key), key, "it"); }),
              HasSubstr("palpate-seal-3"));
  EXPECT_THAT(ComplaintOf([&] { OpenSeal(SealText(Roll{}, key), key, "it"); }),
              HasSubstr("is of format"));
}

}  // namespace
}  // namespace palpate::test
