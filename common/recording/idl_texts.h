#pragma once

namespace palpate {

// The files of idl/ as text, embedded by the build.
extern const char* const kHapticsIdl;
extern const char* const kOfferIdl;
extern const char* const kSessionIdl;
extern const char* const kSolidIdl;
extern const char* const kTeachingIdl;

}  // namespace palpate
