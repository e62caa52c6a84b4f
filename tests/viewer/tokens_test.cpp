#include "client/viewer/tokens.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <sys/stat.h>

#include "common/error.h"
#include "tests/support/complaint.h"
#include "tests/support/folder.h"
#include "tests/support/read_file.h"

namespace palpate {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class TokensTest : public testing::Test {
 protected:
  void Write(const std::string& text, mode_t mode = 0600) {
    std::ofstream(path_) << text;
    chmod(path_.c_str(), mode);
  }
  std::string Text() { return ReadWholeFile(path_); }
  std::string Complaint() {
    return test::ComplaintOf([&] { Tokens::Read(path_); });
  }

  const test::Folder folder_;
  const std::string path_ = folder_ / "tokens.txt";
  const std::string hash_ = std::string(64, 'a');
};

TEST(Roles, HaveNames) {
  for (const Access role : {Access::kWatch, Access::kDrive, Access::kOperate}) {
    EXPECT_EQ(ParseRole(RoleName(role)), role);
  }
  for (const char* word : {"", "none", "Watch", "operate ", "admin"}) {
    EXPECT_FALSE(ParseRole(word)) << word;
  }
}

TEST_F(TokensTest, KnowThoseThatWereMadeAndStandNowhereInTheFileWhichIsForItsOwnerAlone) {
  const std::string teacher = MakeToken(path_, Access::kOperate, "teacher");
  const std::string student = MakeToken(path_, Access::kWatch, "class-7");
  EXPECT_NE(teacher, student);
  const Tokens tokens = Tokens::Read(path_);
  ASSERT_TRUE(tokens.Find(teacher));
  EXPECT_EQ(tokens.Find(teacher)->role, Access::kOperate);
  EXPECT_EQ(tokens.Find(teacher)->name, "teacher");
  ASSERT_TRUE(tokens.Find(student));
  EXPECT_EQ(tokens.Find(student)->role, Access::kWatch);
  EXPECT_THAT(Text(), testing::Not(HasSubstr(teacher.substr(8))));
  struct stat file {};
  stat(path_.c_str(), &file);
  EXPECT_EQ(file.st_mode & 0777, 0600u);
}

TEST_F(TokensTest, AreNamedAsStationsAreAndNoTwoAlike) {
  EXPECT_EQ(StationNameOf("anna"), "anna");
  EXPECT_EQ(StationNameOf("dr.no-1", 12), "dr_no_1_12");
  EXPECT_EQ(StationNameOf(std::string(40, 'x'), 2), std::string(30, 'x') + "_2");
  Write("drive anna.b " + hash_ + "\ndrive anna-b " + std::string(64, 'b') + "\n");
  EXPECT_THAT(Complaint(),
              AllOf(HasSubstr("tokens.txt:2"), HasSubstr("'anna.b'"), HasSubstr("'anna_b'")));
  Write("drive anna " + hash_ + "\ndrive anna_2 " + std::string(64, 'b') + "\n");
  const Tokens tokens = Tokens::Read(path_);
  EXPECT_TRUE(tokens.NamesAnother("anna_2", "", "anna"));
  EXPECT_FALSE(tokens.NamesAnother("anna_2", "", "anna_2"));
  EXPECT_FALSE(tokens.NamesAnother("anna_3", "", "anna"));
  EXPECT_TRUE(tokens.NamesAnother("mouse_anna_2", "mouse_", "anna"));
  EXPECT_THROW(MakeToken(path_, Access::kDrive, "anna-2"), UsageError);
}

TEST_F(TokensTest, KnowNothingElse) {
  const std::string token = MakeToken(path_, Access::kDrive, "hand");
  const Tokens tokens = Tokens::Read(path_);
  std::string other = token;
  other.back() = other.back() == '0' ? '1' : '0';
  for (const std::string& text :
       {std::string(), other, token.substr(1), token + "0", " " + token, token + '\n', hash_,
        std::string("palpate_"), std::string(100'000, 'a')}) {
    EXPECT_FALSE(tokens.Find(text)) << text.substr(0, 100);
  }
  // The hash that the file holds is no token.
  const std::string line = Text();
  EXPECT_FALSE(tokens.Find("palpate_" + line.substr(line.rfind(' ') + 1, 64)));
}

TEST_F(TokensTest, AreOfAFileThatOthersCannotReadOrChange) {
  for (const mode_t mode : {0644u, 0620u, 0604u, 0602u, 0666u}) {
    Write("watch a " + hash_ + "\n", mode);
    EXPECT_THAT(Complaint(), AllOf(HasSubstr("--tokens " + path_), HasSubstr("chmod 0600")))
        << mode;
    EXPECT_THROW(MakeToken(path_, Access::kWatch, "b"), Error);
  }
  for (const mode_t mode : {0600u, 0640u}) {
    Write("watch a " + hash_ + "\n", mode);
    EXPECT_EQ(Complaint(), "no complaint");
  }
  std::filesystem::remove(path_);
  EXPECT_THAT(Complaint(), HasSubstr(path_));
  std::filesystem::create_directory(path_);
  EXPECT_THAT(Complaint(), HasSubstr("is a folder; give the name of a regular file"));
}

TEST_F(TokensTest, KnowWhetherATokenIsStillTheSameOfTheSameRoleAndName) {
  const auto found = [&](const std::string& line) {
    Write(line + "\n");
    return Tokens::Read(path_);
  };
  const std::string other = std::string(64, 'b');
  Tokens::Holder holder{Access::kWatch, "a", {}, 0, "a"};
  holder.hash.fill(0xaa);
  EXPECT_TRUE(found("watch a " + hash_).Has(holder));
  EXPECT_TRUE(found("drive b " + other + "\nwatch a " + hash_).Has(holder));
  EXPECT_FALSE(found("watch a " + other).Has(holder)) << "already has a token";
  EXPECT_FALSE(found("drive a " + hash_).Has(holder)) << "another role";
  EXPECT_FALSE(found("watch b " + hash_).Has(holder)) << "another name";
  EXPECT_EQ(found("drive b " + other + "\nwatch a " + hash_).size(), 2u);
}

TEST_F(TokensTest, NameTheLineThatIsWrong) {
  const std::string good = "# a remark\n\nwatch a " + hash_ + "\n";
  const std::string other = std::string(64, 'b');
  Write(good);
  EXPECT_EQ(Complaint(), "no complaint");
  for (const auto& [line, what] : std::vector<std::pair<std::string, std::string>>{
           {"admin b " + other, "'admin' is not known; give watch, drive or operate"},
           {"drive", "a name has"},
           {"drive b", "64 hexadecimal digits"},
           {"drive b " + other + "0", "64 hexadecimal digits"},
           {"drive b " + std::string(63, 'b') + "g", "64 hexadecimal digits"},
           {"drive b " + other + " more", "no more"},
           {"drive " + std::string(33, 'n') + " " + other, "32 at most"},
           {"drive b/ " + other, "a name has"},
           {"drive a " + other, "is listed twice"},
           {"drive b " + hash_, "has the token of 'a'"}}) {
    Write(good + line + "\n");
    EXPECT_THAT(Complaint(), AllOf(HasSubstr(path_ + ":4: "), HasSubstr(what))) << line;
  }
  Write("# nobody\n");
  EXPECT_THAT(Complaint(), HasSubstr("has no tokens"));
}

TEST_F(TokensTest, AreMadeOnceForEachName) {
  MakeToken(path_, Access::kWatch, "a");
  const std::string before = Text();
  EXPECT_THROW(MakeToken(path_, Access::kOperate, "a"), UsageError);
  EXPECT_THROW(MakeToken(path_, Access::kOperate, "a b"), UsageError);
  EXPECT_THROW(MakeToken(path_, Access::kOperate, "a\noperate"), UsageError);
  EXPECT_EQ(Text(), before);
  // A line without a newline, as some editors leave, stays one line.
  Write("watch a " + hash_);
  MakeToken(path_, Access::kWatch, "b");
  EXPECT_EQ(Complaint(), "no complaint");
}

}  // namespace
}  // namespace palpate
