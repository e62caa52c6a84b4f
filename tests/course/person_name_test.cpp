#include "client/course/person_name.h"

#include <set>
#include <sstream>

#include <gmock/gmock.h>
#include <unicode/normalizer2.h>

#include "client/course/roster.h"
#include "common/text/lower_case.h"
#include "tests/support/complaint.h"
#include "tests/support/folder.h"
#include "tests/support/read_file.h"

namespace palpate {
namespace {

using test::ComplaintOf;
using testing::HasSubstr;

std::string Decomposed(const std::string& text) {
  UErrorCode code = U_ZERO_ERROR;
  std::string out;
  return icu::Normalizer2::getNFDInstance(code)
      ->normalize(icu::UnicodeString::fromUTF8(text), code)
      .toUTF8String(out);
}

std::vector<std::string> Parts(const std::string& text, const std::string& between) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0, end = 0; end != text.npos; begin = end + between.size()) {
    end = text.find(between, begin);
    parts.push_back(text.substr(begin, end == text.npos ? end : end - begin));
  }
  return parts;
}

/// 1,000 full names of 40 scripts: each given with each family name.
std::vector<std::string> SampleNames() {
  std::istringstream in(ReadWholeFile(PALPATE_SOURCE_DIR "/tests/course/names_of_scripts.tsv"));
  std::vector<std::string> names;
  for (std::string line; std::getline(in, line);) {
    if (line[0] == '#') continue;
    const std::vector<std::string> of = Parts(line, "\t");
    const std::string between = of.at(2).substr(1, of.at(2).size() - 2);  // without its brackets
    for (const std::string& given : Parts(of.at(3), ", ")) {
      for (const std::string& family : Parts(of.at(4), ", ")) {
        names.push_back(of[1] == "family" ? family + between + given : given + between + family);
      }
    }
  }
  return names;
}

class PersonNameTest : public testing::Test {
 protected:
  std::string ComplaintOfMaking(const std::string& name) {
    return ComplaintOf([&] { roster_.Make({name}, Access::kDrive); });
  }
  const test::Folder folder_;
  CourseFile file_{folder_ / "course"};
  Roster roster_{file_};
};

TEST_F(PersonNameTest, TakesAThousandNamesOfFortyScriptsAsOneClass) {
  const std::vector<std::string> names = SampleNames();
  ASSERT_EQ(names.size(), 1000u);
  const auto made = roster_.Make(names, Access::kDrive);
  std::set<std::string> stations;
  for (std::size_t i = 0; i < made.size(); ++i) {
    const std::string& station = made[i].person.station;
    EXPECT_EQ(Decomposed(made[i].person.name), Decomposed(names[i])) << "lost a mark or a joiner";
    EXPECT_TRUE(stations.insert(LowerCase(station)).second) << station;
    EXPECT_LE(station.size(), 22u);
    EXPECT_EQ(StationNameOf(station), station);
  }
}

TEST_F(PersonNameTest, KnowsEachOfThemAgainHoweverItIsWritten) {
  const std::vector<std::string> names = SampleNames();
  roster_.Make(names, Access::kDrive);
  for (std::size_t i = 0; i < names.size(); ++i) {
    for (const std::string& written :
         {Decomposed(names[i]), "\ufeff" + names[i], " \u00a0" + names[i] + "\u200b\u200f "}) {
      const Person* const found = roster_.FindName(written);
      ASSERT_NE(found, nullptr) << written;
      EXPECT_EQ(found->id, static_cast<std::int64_t>(i) + 1);
    }
    EXPECT_THAT(ComplaintOfMaking(Decomposed(names[i])), HasSubstr("there is already"));
  }
}

TEST_F(PersonNameTest, RefusesWhatLooksLikeSomebody) {
  roster_.Make({"Anna", "Ian Müller", "علی‌رضا", "Иван", "Straße", "王伟"}, Access::kDrive);
  for (const char* twin : {"anna",
                           "ANNA",
                           "\u0410nna",
                           "Ann\u0430",
                           "An\u200dna",
                           "An\u00adna",
                           "\u3164Anna",
                           "Ａｎｎａ",
                           "Anna\ufe0f",
                           "Anna\U000e0041",
                           "\u2066Anna\u2069",
                           "\u202eAnna",
                           "Anna\u2800",
                           "lan Müller",
                           "Ian  Mu\u0308ller",
                           "Ian\u00a0Müller",
                           "ian MÜLLER",
                           "علیرضا",
                           "ИВАН",
                           "STRASSE"}) {
    EXPECT_THAT(ComplaintOfMaking(twin), AnyOf(HasSubstr("there is already"), HasSubstr("looks")))
        << twin;
  }
  // Near, and not the same.
  for (const char* other : {"Lan Müller", "Ian Muller", "Anna 2", "Anne", "Ivan", "王薇", "汪伟"}) {
    EXPECT_EQ(ComplaintOfMaking(other), "no complaint") << other;
  }
}

TEST_F(PersonNameTest, KeepsWhatBelongsAndLeavesOutWhatShowsNothing) {
  for (const auto& [written, kept] : std::vector<std::pair<std::string, std::string>>{
           {" Mu\u0308ller\t", "Müller"},
           {"\ufeff\u200bAnna\u2060\u061c\u200e", "Anna"},
           {"\u202aAnna\u202c", "Anna"},
           {"Anna  \u00a0 Lind", "Anna Lind"},
           {"An\u200dna\u200c", "Anna"},
           {"ហេង\u200bសំណាង", "ហេងសំណាង"},
           {"علی\u200cرضا\u200c", "علی\u200cرضا"},
           {"അനില\u0d4d\u200d", "അനില\u0d4d\u200d"},
           {"\u0301Anna", "Anna"},
           {"葛\U000e0100城", "葛\U000e0100城"}}) {
    EXPECT_EQ(PersonName(written), kept);
    EXPECT_EQ(PersonName(kept), kept);
  }
}

TEST_F(PersonNameTest, RefusesControlsAndWhatIsNoName) {
  for (const char* name :
       {"", " \u200b\ufeff", "---", "\u3164", "a\nb", "a\x1b[31mb", "a\u0085b", "An\u202ean",
        "An\u2067an", "a\xff", "a\xed\xa0\x80", "\ufdd0a", "\u0301\u0302"}) {
    EXPECT_NE(ComplaintOf([&] { PersonName(name); }), "no complaint") << name;
  }
}

TEST_F(PersonNameTest, CountsLettersNotBytes) {
  const auto repeated = [](const char* letter, int count) {
    std::string text;
    for (int i = 0; i < count; ++i) text += letter;
    return text;
  };
  for (const char* letter : {"a", "я", "語", "\U00020bb7", "ம்", "e\u0323\u0302"}) {
    EXPECT_EQ(ComplaintOf([&] { PersonName(repeated(letter, 64)); }), "no complaint") << letter;
    EXPECT_THAT(ComplaintOf([&] { PersonName(repeated(letter, 65)); }),
                HasSubstr("more than 64 letters"))
        << letter;
  }
  EXPECT_THAT(ComplaintOf([&] { PersonName("a" + repeated("\u0334", 1000)); }),
              HasSubstr("more than 64 letters"));
}

TEST_F(PersonNameTest, NamesStationsInLatinLettersWithANumberWhereThatDoesNotDo) {
  const auto made = roster_.Make({"Eva Müller", "Eva Muller", "王伟", "汪伟", "ហេង សុខា",
                                  "Александр Константинопольский", "Eva_Muller_2"},
                                 Access::kDrive);
  std::vector<std::string> stations;
  for (const auto& one : made) stations.push_back(one.person.station);
  EXPECT_THAT(stations,
              testing::ElementsAre("Eva_Muller", "Eva_Muller_2", "wang_wei", "wang_wei_4",
                                   "person_5", "Aleksandr_Konstantin_6", "Eva_Muller_2_7"));
  EXPECT_EQ(FileNameOf("Eva/Müller: ..\\x."), "Eva_Müller_ .._x");
}

}  // namespace
}  // namespace palpate
