#include "scenes/importer/mesh_text.h"

#include <charconv>
#include <cstdlib>
#include <system_error>

#include "common/error.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

bool IsBlank(char c) {
  return static_cast<unsigned char>(c) <= ' ';
}

}  // namespace

bool ReadNumber(std::string_view word, double& value) {
  if (word.starts_with('+')) word.remove_prefix(1);
  if (word.starts_with('+')) return false;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (end != word.data() + word.size() || error == std::errc::invalid_argument) return false;
  // Out of the range of double: use infinity or zero.
  if (error != std::errc()) value = std::strtod(std::string(word).c_str(), nullptr);
  return true;
}

MeshText::MeshText(std::string_view text) : text_(text) {
  if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff")) {
    throw Error("its text is UTF-16; save it as UTF-8 or ASCII");
  }
  if (text.starts_with("\xef\xbb\xbf")) at_ = 3;
}

void MeshText::SkipBlanks() {
  while (!done() && IsBlank(text_[at_])) ++at_;
}

std::string_view MeshText::Word() {
  SkipBlanks();
  const std::size_t begin = at_;
  while (!done() && !IsBlank(text_[at_])) ++at_;
  return text_.substr(begin, at_ - begin);
}

double MeshText::Number() {
  const std::string_view word = Word();
  double value = 0.0;
  if (word.empty()) Fail("it ends where a number is expected");
  if (!ReadNumber(word, value)) Fail(Quoted(word) + " is not a number");
  return value;
}

std::string_view MeshText::Line() {
  std::size_t begin = at_;
  while (!done() && !AtLineEnd()) ++at_;
  std::size_t end = at_;
  SkipLineEnd();
  while (begin < end && IsBlank(text_[begin])) ++begin;
  while (begin < end && IsBlank(text_[end - 1])) --end;
  return text_.substr(begin, end - begin);
}

bool MeshText::AtJoint() const {
  return text_[at_] == '\\' && at_ + 1 < text_.size() &&
         (text_[at_ + 1] == '\n' || text_[at_ + 1] == '\r');
}

void MeshText::SkipLineEnd() {
  if (rest().starts_with("\r\n")) ++at_;
  if (!done()) ++at_;
}

std::string_view MeshText::WordOfLine() {
  for (; !done() && !AtLineEnd(); ++at_) {
    if (AtJoint()) {
      ++at_;
      SkipLineEnd();
      --at_;
    } else if (!IsBlank(text_[at_])) {
      break;
    }
  }
  if (!done() && text_[at_] == '#') {
    while (!done() && !AtLineEnd()) ++at_;
  }
  const std::size_t begin = at_;
  while (!done() && !IsBlank(text_[at_]) && !AtJoint()) ++at_;
  return text_.substr(begin, at_ - begin);
}

void MeshText::EndLine() {
  while (!WordOfLine().empty()) {
  }
  SkipLineEnd();
}

void MeshText::Fail(const std::string& why) const {
  std::size_t line = 1;
  for (std::size_t i = 0; i < at_; ++i) {
    line += text_[i] == '\n' || (text_[i] == '\r' && i + 1 < at_ && text_[i + 1] != '\n');
  }
  throw Error("line " + std::to_string(line) + ": " + why + kExportAgain);
}

}  // namespace palpate
