#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <regex>
#include <set>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "client/replayer/certificate/certificate.h"
#include "common/files/whole_file.h"
#include "common/text/hex16.h"
#include "scenes/catalogue.h"
#include "tests/replayer/hand_recording.h"
#include "tests/support/complaint.h"
#include "tests/support/folder.h"

namespace palpate::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr std::uint64_t kSealedPoses = 50;
const std::string kAnna = "trials/3/press/1", kBen = "trials/4/press/1";

/// Two people's trials of pressing into a cube, handed in for an exam.
class SealedTest : public testing::Test {
 protected:
  SealedTest()
      : scene_(LoadScene("cube")),
        model_(MakeModel(scene_, scene_.tools.front(), MakeObjects(scene_))) {
    fs::create_directory(folder_ / "exams");
    Write("midterm.exam.json", R"({"title": {"en": "Midterm", "de": "Zwischenprüfung"},
      "time_s": 600, "tasks": [{"exercise": "light-force"}]})");
    Record(kAnna, "Anna", 9);
    Record(kBen, "Ben", 10);
    SealBoth();
  }

  void Record(const std::string& stem, const std::string& station, std::uint64_t run) {
    fs::create_directories(fs::path(folder_ / stem).parent_path());
    const auto at = [&](std::uint64_t i) {
      return Pose{Vec3(1e-5 * static_cast<double>(i * run), 0.029, 0.0), Quat::Identity()};
    };
    const auto lie = [&](std::uint64_t i, wire::Wrench& wrench) {
      if (i == 20) wrench.force_N[0] += lie_N_;
    };
    hash_ = Hex16(RecordHand(scene_, model_, {station, run, kSealedPoses, at, lie},
                             folder_ / (stem + ".mcap")));
  }
  Seal SealOf(const std::string& stem, std::int64_t person, const std::string& name) const {
    const HashedFile hashed = Sha256OfFile(folder_ / (stem + ".mcap"));
    Seal seal;
    seal.recording = stem + ".mcap";
    seal.sha256 = hashed.sha256;
    seal.bytes = hashed.bytes;
    seal.person = person;
    seal.name = seal.station = name;
    seal.scene = scene_.name;
    seal.scene_hash = hash_;
    seal.exam = "midterm";
    seal.exam_number = 1;
    seal.exercise = "light-force";
    seal.task = seal.n = 1;
    seal.criteria_sha256 = Sha256("criteria");
    seal.ended_s = 1'800'000'000;
    seal.sealed_s = 1'800'003'600;
    return seal;
  }
  void Write(const std::string& file, const std::string& text) const {
    std::ofstream(folder_ / file, std::ios::binary) << text;
  }
  /// Seals these trials one after another, and their roll.
  void SealAll(std::vector<std::pair<std::string, Seal>> seals) const {
    const Exam exam = LoadExam(folder_ / "midterm.exam.json");
    Roll roll;
    roll.exam = exam.name;
    roll.exam_number = 1;
    roll.exam_sha256 = exam.sha256;
    roll.tasks = exam.tasks;
    roll.closed_s = 1'800'007'200;
    roll.complete = true;
    for (auto& [stem, seal] : seals) {
      seal.previous = roll.last;
      const std::string text = SealText(seal, key_);
      Write(stem + kSealEnding, text);
      roll.last = Sha256(text);
      Roll::Entry entry;
      entry.person = seal.person;
      entry.name = seal.name;
      entry.task = seal.task;
      entry.n = seal.n;
      entry.recording = seal.recording;
      entry.sha256 = seal.sha256;
      entry.seal = roll.last;
      roll.trials.push_back(entry);
    }
    WriteRoll(roll);
  }
  void SealBoth() const {
    SealAll({{kAnna, SealOf(kAnna, 3, "Anna")}, {kBen, SealOf(kBen, 4, "Ben")}});
  }
  void WriteRoll(const Roll& roll) const { Write(kRoll, SealText(roll, key_)); }
  Roll ReadRoll() const { return OpenRoll(Read(kRoll), key_, kRoll); }
  std::string Read(const std::string& file) const { return ReadWholeFile(folder_ / file, 1 << 24); }
  Certificate Verified(const std::string& exam = "") const {
    return VerifySealed({.folder = folder_.path(), .exam = exam, .key = public_key_});
  }
  static constexpr const char* kRoll = "exams/midterm-1.roll.json";
  /// Why the first trial, Anna's, is refused.
  std::string Refused() const { return Verified().trials.at(0).refused; }

  const Folder folder_;
  const std::string public_key_ = folder_ / SealKey::kPublicFile;
  const SealKey key_ = SealKey::OfCourse(folder_.path());
  const Scene scene_;
  const HapticModel model_;
  std::string hash_;
  double lie_N_ = 0.0;
};

TEST_F(SealedTest, IsVerifiedInEveryBitAndTheCertificateSaysWhatWasNot) {
  const Certificate certificate = Verified();
  EXPECT_TRUE(certificate.good()) << ToText(certificate);
  EXPECT_EQ(certificate.exam, "midterm-1");
  ASSERT_EQ(certificate.trials.size(), 2u);
  EXPECT_EQ(certificate.trials[0].wrenches, kSealedPoses);
  EXPECT_THAT(ToText(certificate), HasSubstr("VERIFIED: 2 of 2"));
  EXPECT_THAT(ToText(certificate), HasSubstr("Who held the stylus"));
  WriteCertificate(certificate, folder_ / "out");
  EXPECT_THAT(Read("out/certificate.html"), HasSubstr("<td>Anna (3)<td>1: Light force"));
  EXPECT_THAT(Read("out/certificate.html"),
              HasSubstr("<td>2027-01-15 08:00:00 UTC<td>2027-01-15 09:00:00 UTC<td>"));
  EXPECT_THAT(Read("out/certificate.de.html"), HasSubstr("Zwischenprüfung (midterm-1)"));
  EXPECT_THAT(Read("out/certificate.html"),
              HasSubstr("<a href=\"certificate.de.html\" lang=\"de\""));
  EXPECT_THAT(Read("out/certificate.de.html"), HasSubstr("GEPRÜFT: 2 von 2"));
  EXPECT_THAT(Read("out/certificate.de.html"), HasSubstr("bestätigt: 0,0 s, 50 Kräfte"));
  EXPECT_THAT(Read("out/certificate.zh.html"), HasSubstr("2 次操作中 2 次已验证"));
  EXPECT_THAT(Read("out/certificate.json"), HasSubstr("\"good\": true"));
}

TEST_F(SealedTest, OneRecordingIsVerifiedByItself) {
  EXPECT_TRUE(VerifySealed({.recording = folder_ / (kAnna + ".mcap"), .key = public_key_}).good());
}

TEST_F(SealedTest, OfWhichAnyByteIsFlippedIsRefused) {
  std::mt19937 random(20261127);
  for (const char* ending : {".mcap", kSealEnding}) {
    const std::string file = kAnna + ending, good = Read(file);
    for (int i = 0; i < 60; ++i) {
      std::string spoilt = good;
      const std::size_t at = random() % spoilt.size();
      spoilt[at] = static_cast<char>(spoilt[at] ^ (1 << (random() % 8)));
      Write(file, spoilt);
      const Certificate one =
          VerifySealed({.recording = folder_ / (kAnna + ".mcap"), .key = public_key_});
      EXPECT_THAT(one.trials.at(0).refused, HasSubstr("changed")) << ending << " at " << at;
    }
    Write(file, good);
  }
  EXPECT_TRUE(Verified().good());
}

TEST_F(SealedTest, ThatIsCutIsRefused) {
  fs::resize_file(folder_ / (kAnna + ".mcap"), 1000);
  EXPECT_THAT(Refused(), HasSubstr("is truncated: 1000 of "));
  fs::remove(folder_ / (kAnna + ".mcap"));
  EXPECT_THAT(Refused(), HasSubstr("is not there"));
}

TEST_F(SealedTest, OfAnotherCourseIsRefused) {
  const Folder other;
  Write(kAnna + kSealEnding, SealText(SealOf(kAnna, 3, "Anna"), SealKey::OfCourse(other.path())));
  EXPECT_THAT(Refused(), HasSubstr("another course's"));
}

TEST_F(SealedTest, OfAnotherVersionIsVerifiedIfItsPhysicsGivesTheSameBits) {
  // As if an earlier version had sealed it.
  std::string text = Read(kAnna + kSealEnding);
  const std::size_t begin = text.find("\"sealed\":") + 9, end = text.rfind(",\"signature\"");
  std::string body = text.substr(begin, end - begin);
  body.replace(body.find(PALPATE_VERSION), std::string_view(PALPATE_VERSION).size(), "0.0.1");
  text = "{\"key\":\"" + key_.name() + "\",\"sealed\":" + body + ",\"signature\":\"" +
         key_.Sign(body) + "\"}\n";
  Write(kAnna + kSealEnding, text);
  fs::remove(folder_ / (kBen + kSealEnding));
  Roll roll = ReadRoll();
  roll.trials.resize(1);
  roll.trials.front().seal = roll.last = Sha256(text);
  WriteRoll(roll);
  EXPECT_TRUE(Verified().good()) << ToText(Verified());
}

TEST_F(SealedTest, OfAnotherPersonIsRefusedUnderWhateverName) {
  for (const char* ending : {".mcap", kSealEnding}) {
    fs::copy_file(folder_ / (kBen + ending), folder_ / (kAnna + ending),
                  fs::copy_options::overwrite_existing);
  }
  EXPECT_THAT(Refused(), HasSubstr("it is the seal of trials/4/press/1.mcap, and lies beside"));
  // Also if the recording was replaced before it was sealed.
  SealBoth();
  EXPECT_THAT(Refused(), HasSubstr("of station 'Ben', not of 'Anna'"));
  EXPECT_EQ(Verified().trials.at(1).refused, "");
}

TEST_F(SealedTest, HandedInForTwoIsRefusedForBoth) {
  // First the files are the same, then only the session.
  fs::copy_file(folder_ / (kAnna + ".mcap"), folder_ / (kBen + ".mcap"),
                fs::copy_options::overwrite_existing);
  const auto seal_for_two = [&] {
    SealAll({{kAnna, SealOf(kAnna, 3, "Anna")}, {kBen, SealOf(kBen, 4, "Anna")}});
  };
  seal_for_two();
  Certificate certificate = Verified();
  EXPECT_THAT(certificate.trials[0].refused,
              HasSubstr("the same recording was also submitted for"));
  EXPECT_THAT(certificate.trials[1].refused,
              HasSubstr("the same recording was also submitted for"));
  std::ofstream(folder_ / (kBen + ".mcap"), std::ios::app) << ' ';
  seal_for_two();
  certificate = Verified();
  EXPECT_NE(certificate.trials[0].refused, "");
  EXPECT_NE(certificate.trials[1].refused, "");
}

TEST_F(SealedTest, CutShortBeforeTheFirstMessageIsEqualToOthersAndVerified) {
  // What a recorder has written by then: the magic bytes and the header, whose length is at 9.
  const std::string whole = Read(kAnna + ".mcap");
  std::uint64_t header = 0;
  std::memcpy(&header, whole.data() + 9, sizeof header);
  for (const std::string& stem : {kAnna, kBen}) Write(stem + ".mcap", whole.substr(0, 17 + header));
  SealBoth();
  const Certificate certificate = Verified();
  EXPECT_TRUE(certificate.good()) << ToText(certificate);
  EXPECT_EQ(certificate.trials[0].wrenches, 0u);
}

TEST_F(SealedTest, OfAnotherSceneOrOfForcesThatNoPhysicsGaveIsRefused) {
  Seal seal = SealOf(kAnna, 3, "Anna");
  seal.scene_hash = "0000000000000001";
  Write(kAnna + kSealEnding, SealText(seal, key_));
  EXPECT_THAT(Refused(), HasSubstr("not of 'cube' with 0000000000000001"));
  lie_N_ = 1e-12;
  Record(kAnna, "Anna", 9);
  SealBoth();
  EXPECT_THAT(Refused(), HasSubstr("differ from the computed ones"));
}

TEST_F(SealedTest, ThatIsLeftOutIsMissedAndWhatWasNotHandedInIsRefused) {
  const std::string bens = Read(kBen + kSealEnding);
  fs::remove(folder_ / (kBen + kSealEnding));
  EXPECT_THAT(Verified().missing.at(0), HasSubstr("Ben, task 1: trial 1"));
  SealAll({{kAnna, SealOf(kAnna, 3, "Anna")}});
  EXPECT_TRUE(Verified().good());
  Write(kBen + kSealEnding, bens);
  EXPECT_THAT(Verified().trials.at(1).refused, HasSubstr("not on the exam's roll"));
}

TEST_F(SealedTest, WithoutACompleteRollIsNotVerified) {
  Roll roll = ReadRoll();
  roll.complete = false;
  WriteRoll(roll);
  EXPECT_THAT(Verified().missing.at(0), HasSubstr("not closed"));
  Write(kRoll, "{}");
  EXPECT_FALSE(Verified().good());
  fs::remove(folder_ / kRoll);
  EXPECT_FALSE(Verified().good());
}

TEST_F(SealedTest, WhoseChainIsBrokenIsNotVerified) {
  Roll roll = ReadRoll();
  std::swap(roll.trials.front(), roll.trials.back());
  WriteRoll(roll);
  EXPECT_TRUE(Verified().good()) << "the roll's order is free";
  roll.last = roll.trials.back().seal;
  WriteRoll(roll);
  EXPECT_THAT(Verified().trials.at(1).refused, HasSubstr("no other seal names"));
  roll.last = Sha256("another");
  WriteRoll(roll);
  EXPECT_FALSE(Verified().good());
}

TEST_F(SealedTest, ThatIsRefusedSpoilsNothingWhereTheExaminerHadItDoneAgain) {
  lie_N_ = 1e-12;
  Record(kAnna, "Anna", 9);
  SealBoth();
  EXPECT_FALSE(Verified().good());
  Roll roll = ReadRoll();
  roll.trials.front().counts = false;
  WriteRoll(roll);
  EXPECT_NE(Refused(), "");
  EXPECT_TRUE(Verified().good());
}

TEST_F(SealedTest, ThatWasLostIsMissedUnlessTheExaminerHadItDoneAgain) {
  Roll roll = ReadRoll();
  Roll::Entry lost = roll.trials.front();
  lost.seal.clear();
  lost.lost = "its mark is gone";
  roll.trials.push_back(lost);
  WriteRoll(roll);
  EXPECT_THAT(Verified().missing.at(0), HasSubstr("its mark is gone"));
  roll.trials.back().counts = false;
  WriteRoll(roll);
  EXPECT_TRUE(Verified().good());
}

TEST_F(SealedTest, BesideALinkToNowhereIsVerifiedStill) {
  fs::create_symlink("loop.seal.json", folder_ / "loop.seal.json");
  const Certificate certificate = Verified();
  ASSERT_EQ(certificate.trials.size(), 3u);
  EXPECT_EQ(certificate.trials[0].file, "loop.seal.json");
  EXPECT_THAT(certificate.trials[0].refused, HasSubstr("loop.seal.json"));
  EXPECT_EQ(certificate.trials[1].refused, "");
}

TEST_F(SealedTest, OfSeveralExamsIsVerifiedForTheOneThatIsNamed) {
  Seal seal = SealOf(kBen, 4, "Ben");
  seal.exam = "final";
  Write(kBen + kSealEnding, SealText(seal, key_));
  EXPECT_THAT(ComplaintOf([&] { Verified(); }), HasSubstr("final-1, midterm-1; choose"));
  EXPECT_EQ(Verified("final").trials.size(), 1u);
}

TEST(CertificateCatalogues, SayAllThatTheEnglishOneSays) {
  const auto placeholders = [](const std::string& text) {
    static const std::regex kPlaceholder("\\{\\w+\\}");
    return std::set<std::string>(std::sregex_token_iterator(text.begin(), text.end(), kPlaceholder),
                                 std::sregex_token_iterator());
  };
  const auto english = nlohmann::json::parse(kCertificateCatalogues.front().second);
  for (const auto& [tag, text] : kCertificateCatalogues) {
    const auto catalogue = nlohmann::json::parse(text);
    EXPECT_EQ(catalogue.size(), english.size()) << tag;
    for (const auto& [key, words] : english.items()) {
      ASSERT_TRUE(catalogue.contains(key)) << tag << ": " << key;
      EXPECT_EQ(catalogue[key].size(), words.size()) << tag << ": " << key;
      EXPECT_EQ(placeholders(catalogue[key].dump()), placeholders(words.dump()))
          << tag << ": " << key;
    }
  }
}

}  // namespace
}  // namespace palpate::test
