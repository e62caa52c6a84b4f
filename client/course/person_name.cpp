#include "client/course/person_name.h"

#include <memory>

#include <fmt/format.h>
#include <unicode/brkiter.h>
#include <unicode/normalizer2.h>
#include <unicode/translit.h>
#include <unicode/uchar.h>
#include <unicode/uspoof.h>

#include "common/error.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

using icu::UnicodeString;

/// More belong to no letter of any language.
constexpr int kMostCodesOfLetter = 4;
constexpr UChar32 kZwnj = 0x200c, kZwj = 0x200d, kMongolianSeparator = 0x180e, kUnreadable = 0xfffd;
constexpr UChar32 kBrailleBlank = 0x2800;

/// ICU has its data in the library: it fails only without memory, or if an installation is broken.
void Check(UErrorCode code) {
  if (U_FAILURE(code)) {
    throw Error(fmt::format("ICU: {}; install the package libicu72 again", u_errorName(code)));
  }
}

std::string Utf8(const UnicodeString& text) {
  std::string utf8;
  return text.toUTF8String(utf8);
}

UnicodeString Composed(const UnicodeString& text) {
  UErrorCode code = U_ZERO_ERROR;
  UnicodeString composed = icu::Normalizer2::getNFCInstance(code)->normalize(text, code);
  Check(code);
  return composed;
}

bool IsBlank(UChar32 c) {
  return u_isUWhiteSpace(c) || c == kBrailleBlank;
}

bool IsMark(UChar32 c) {
  return (U_GET_GC_MASK(c) & U_GC_M_MASK) != 0;
}

bool IsIgnorable(UChar32 c) {
  return u_hasBinaryProperty(c, UCHAR_DEFAULT_IGNORABLE_CODE_POINT);
}

/// Variation selectors and the like are marks: they choose a letter's form.
bool ShowsNothing(UChar32 c) {
  return IsIgnorable(c) && !IsMark(c);
}

bool IsJoiner(UChar32 c) {
  return c == kZwnj || c == kZwj || c == kMongolianSeparator;
}

/// Returns whether a joiner after this letter shapes it: its script joins letters, or is Indic.
bool Shapes(UChar32 letter) {
  return u_getIntPropertyValue(letter, UCHAR_JOINING_TYPE) != U_JT_NON_JOINING ||
         u_getIntPropertyValue(letter, UCHAR_INDIC_SYLLABIC_CATEGORY) != U_INSC_OTHER;
}

/// Returns the text without what shows nothing at both ends.  A joiner stays at the end if it
/// shapes the last letter, as in Malayalam; ZWNJ parts that from a next one only.
UnicodeString TrimmedEnds(const UnicodeString& text) {
  int begin = 0;
  int end = text.length();
  while (begin < end) {
    const UChar32 c = text.char32At(begin);
    if (!IsBlank(c) && !IsIgnorable(c) && !IsMark(c)) break;
    begin += U16_LENGTH(c);
  }
  while (end > begin) {
    const int last = text.moveIndex32(end, -1);
    const UChar32 c = text.char32At(last);
    const bool shapes = c == kZwj && last > begin && Shapes(text.char32At(last - 1));
    if ((!IsBlank(c) && !ShowsNothing(c)) || shapes) break;
    end = last;
  }
  return {text, begin, end - begin};
}

/// Returns whether a name may not hold it: controls, ends of lines, changes of direction.
bool IsForbidden(UChar32 c) {
  const bool is_mark_of_direction = c == 0x200e || c == 0x200f || c == 0x061c;
  return c == kUnreadable || u_charType(c) == U_CONTROL_CHAR || c == 0x2028 || c == 0x2029 ||
         (u_hasBinaryProperty(c, UCHAR_BIDI_CONTROL) && !is_mark_of_direction);
}

/// Returns the text without code points for which `leaves_out` is true.
template <class Predicate>
UnicodeString Without(const UnicodeString& text, Predicate leaves_out) {
  UnicodeString kept;
  for (int i = 0; i < text.length(); i = text.moveIndex32(i, 1)) {
    if (const UChar32 c = text.char32At(i); !leaves_out(c)) kept.append(c);
  }
  return kept;
}

/// Returns the text with single spaces, and without what shows nothing.
UnicodeString Cleaned(const UnicodeString& text) {
  UnicodeString kept;
  for (int i = 0; i < text.length(); i = text.moveIndex32(i, 1)) {
    const UChar32 c = text.char32At(i);
    const UChar32 before = kept.isEmpty() ? 0 : kept.char32At(kept.length() - 1);
    if (IsBlank(c)) {
      if (before != ' ') kept.append(UChar32(' '));
    } else if (IsJoiner(c) ? Shapes(before) : !ShowsNothing(c)) {
      kept.append(c);
    }
  }
  return kept;
}

int LettersIn(const UnicodeString& text) {
  UErrorCode code = U_ZERO_ERROR;
  const std::unique_ptr<icu::BreakIterator> letters(
      icu::BreakIterator::createCharacterInstance(icu::Locale::getRoot(), code));
  Check(code);
  letters->setText(text);
  int count = 0;
  while (letters->next() != icu::BreakIterator::DONE) ++count;
  return count;
}

/// Returns whether a code point of the text has the property.
template <class Predicate>
bool Any(const UnicodeString& text, Predicate has) {
  for (int i = 0; i < text.length(); i = text.moveIndex32(i, 1)) {
    if (has(text.char32At(i))) return true;
  }
  return false;
}

std::string SkeletonOf(const UnicodeString& text) {
  UErrorCode code = U_ZERO_ERROR;
  static USpoofChecker* const checker = uspoof_open(&code);
  Check(code);
  UnicodeString skeleton;
  uspoof_getSkeletonUnicodeString(checker, 0, Without(text, IsIgnorable), skeleton, &code);
  Check(code);
  return Utf8(skeleton);
}

}  // namespace

std::string PersonName(std::string_view written) {
  const UnicodeString text = TrimmedEnds(Composed(UnicodeString::fromUTF8(std::string(written))));
  const auto refuse = [&](const std::string& why) {
    throw Error(fmt::format("the name {} {}", Quoted(Utf8(text)), why));
  };
  if (text.isEmpty()) throw Error("the name is empty; give one");
  if (Any(text, IsForbidden)) refuse("has invisible characters; type it again");
  const UnicodeString name = Composed(Cleaned(text));
  // The limit of code points is for letters under heaps of marks.
  if (name.countChar32() > kMostCodesOfLetter * kLongestPersonName ||
      LettersIn(name) > kLongestPersonName) {
    refuse(fmt::format("has more than {} letters; shorten it", kLongestPersonName));
  }
  if (!Any(name, u_isalnum)) refuse("has no letter or digit; add one");
  std::string kept = Utf8(name);
  if (Printable(kept) != kept) refuse("has invisible characters; type it again");
  return kept;
}

NameLook LookOf(std::string_view name) {
  const UnicodeString text = Cleaned(TrimmedEnds(UnicodeString::fromUTF8(std::string(name))));
  UErrorCode code = U_ZERO_ERROR;
  const UnicodeString lower =
      icu::Normalizer2::getNFKCCasefoldInstance(code)->normalize(text, code);
  Check(code);
  return {SkeletonOf(text), SkeletonOf(lower)};
}

bool LookAlike(const NameLook& a, const NameLook& b) {
  return a.as_written == b.as_written || a.in_lower_case == b.in_lower_case;
}

std::string InLatin(std::string_view name) {
  UErrorCode code = U_ZERO_ERROR;
  static const std::unique_ptr<icu::Transliterator> to_latin(
      icu::Transliterator::createInstance("Any-Latin; Latin-ASCII", UTRANS_FORWARD, code));
  Check(code);
  UnicodeString text = UnicodeString::fromUTF8(std::string(name));
  to_latin->transliterate(text);
  std::string latin;
  for (int i = 0; i < text.length(); i = text.moveIndex32(i, 1)) {
    const UChar32 c = text.char32At(i);
    if (c < 0x80 && u_isalnum(c)) {
      latin += static_cast<char>(c);
    } else if (c < 0x80 && c != '\'' && !latin.empty() && latin.back() != '_') {
      latin += '_';
    }
  }
  while (latin.ends_with('_')) latin.pop_back();
  return latin;
}

std::string FileNameOf(std::string_view name) {
  constexpr std::string_view kNotInNames = "<>:\"/\\|?*";
  std::string file(name);
  for (char& c : file) {
    if (kNotInNames.find(c) != kNotInNames.npos || static_cast<unsigned char>(c) < 0x20) c = '_';
  }
  while (file.starts_with('.')) file.erase(0, 1);
  while (file.ends_with('.')) file.pop_back();  // Windows takes neither
  return file;
}

}  // namespace palpate
