#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "client/replayer/verify/sealed.h"

namespace palpate {

/// The languages of certificates, English first: BCP 47 tag and catalogue (certificate/TAG.json).
extern const std::vector<std::pair<std::string_view, std::string_view>> kCertificateCatalogues;

std::string ToText(const Certificate& certificate);
/// @param file  "-" is stdout.  Throws Error.
void WriteJson(const Certificate& certificate, const std::string& file);
/// Writes the certificate into a folder, which it creates: certificate.txt and .json in
/// English; certificate.html, certificate.de.html and so on, printable and linked to each
/// other.  Throws Error.
void WriteCertificate(const Certificate& certificate, const std::string& folder);

}  // namespace palpate
