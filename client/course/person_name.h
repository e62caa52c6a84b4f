#pragma once

#include <string>
#include <string_view>

namespace palpate {

/// Names of people in any script, by ICU.  Lengths are counted in letters as their readers count
/// them (grapheme clusters, UAX #29): a code point more for each vowel sign would give a Tamil name
/// half the length of a Latin one.
inline constexpr int kLongestPersonName = 64;

/// Returns a name as it is stored: composed (NFC), with single spaces.  White space and what shows
/// nothing (U+FEFF, U+200B, direction marks) is left out.  Marks stay, and so do joiners after
/// letters that they shape, as in Persian and Malayalam.
/// Throws Error if it is too long, has no letter or digit, or holds controls or a change of
/// direction, by which it would look like another.
std::string PersonName(std::string_view written);

/// What a reader takes a name for: its skeleton after UTS #39, as written and without case.  Both
/// are needed: 'I' looks like 'l' and 'i' does not.
struct NameLook {
  std::string as_written, in_lower_case;
};
NameLook LookOf(std::string_view name);
bool LookAlike(const NameLook& a, const NameLook& b);

/// Returns the name in Latin letters, as far as ICU knows its script: [A-Za-z0-9_]*.
std::string InLatin(std::string_view name);

/// Returns the name as that of a file: what file systems and shells do not take becomes '_'.
std::string FileNameOf(std::string_view name);

}  // namespace palpate
