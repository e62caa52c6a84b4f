#include "common/text/quoted.h"

#include <cstdio>

#include <gtest/gtest.h>

namespace palpate {
namespace {

TEST(Quoted, IsShortOfOneLineAndNotCutWithinACharacter) {
  EXPECT_EQ(Quoted("cube"), "'cube'");
  EXPECT_EQ(Quoted("a\nready: \x1b[31m"), R"('a\nready: \x1b[31m')");
  EXPECT_EQ(Quoted(std::string(40, 'x')), "'" + std::string(40, 'x') + "'");
  EXPECT_EQ(Quoted(std::string(60'000, 'x')), "'" + std::string(40, 'x') + "…'");
  EXPECT_EQ(Quoted(std::string(39, 'x') + "äöü"), "'" + std::string(39, 'x') + "…'");
  EXPECT_EQ(Quoted(std::string(38, 'x') + "äöü"), "'" + std::string(38, 'x') + "ä…'");
}

TEST(Printable, LeavesWhatCanBeRead) {
  EXPECT_EQ(Printable("Zähne 歯 🦷 a\\b 'c'"), "Zähne 歯 🦷 a\\b 'c'");
  EXPECT_EQ(Printable(""), "");
}

TEST(Printable, EscapesWhatEndsALineCommandsATerminalOrIsNoCharacter) {
  EXPECT_EQ(Printable("a\r\n\tb"), R"(a\r\n\tb)");
  EXPECT_EQ(Printable("\x1b[2K\x7f"), R"(\x1b[2K\x7f)");
  EXPECT_EQ(Printable(std::string_view("a\0b", 3)), R"(a\x00b)");
  EXPECT_EQ(Printable("\xc2\x85\xc2\x9b"
                      "31m"),
            R"(\u0085\u009b31m)")
      << "C1: NEL and CSI";
  EXPECT_EQ(Printable("a\u2028b\u202ec"), R"(a\u2028b\u202ec)");
  EXPECT_EQ(Printable("a\uffff\ufdd0\U0001fffe"), R"(a\uffff\ufdd0\u1fffe)");
  EXPECT_EQ(Printable("a\xff\x9b"
                      "b"),
            R"(a\xff\x9bb)");
  EXPECT_EQ(Printable("\xc0\x8a"), R"(\xc0\x8a)") << "an overlong newline";
  EXPECT_EQ(Printable("\xed\xa0\x80"), R"(\xed\xa0\x80)") << "half of a pair";
  EXPECT_EQ(Printable("\xe4\xb8"), R"(\xe4\xb8)") << "cut off";
  EXPECT_EQ(Printable("\xf4\x90\x80\x80"), R"(\xf4\x90\x80\x80)") << "beyond the last";
}

TEST(ShellWord, IsOneWordToAShellWhateverIsInIt) {
  EXPECT_EQ(ShellWord("day/lesson_1.mcap"), "day/lesson_1.mcap");
  EXPECT_EQ(ShellWord("my tooth.stl"), "'my tooth.stl'");
  for (const std::string word : {"", "my tooth.stl", "it's", "$(touch x)", "~", "a\\b", "Zähne",
                                 "a\nb\x1b[2K'\\\xff", "*"}) {
    const std::string command = "bash -c " + ShellWord("printf %s " + ShellWord(word));
    std::FILE* const shell = popen(command.c_str(), "r");
    char said[64] = {};
    const std::size_t size = std::fread(said, 1, sizeof said, shell);
    pclose(shell);
    EXPECT_EQ(std::string(said, size), word) << command;
    EXPECT_EQ(Printable(command), command);
  }
}

}  // namespace
}  // namespace palpate
