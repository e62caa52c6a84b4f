#include "common/dds/identity.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <regex>
#include <set>

#include <openssl/bio.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/pkcs7.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>
#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/error.h"
#include "common/files/whole_file.h"
#include "common/text/quoted.h"

namespace palpate::dds {
namespace {

namespace fs = std::filesystem;

template <class T, void (*kFree)(T*)>
struct Freed {
  void operator()(T* one) const { kFree(one); }
};
using Certificate = std::unique_ptr<X509, Freed<X509, X509_free>>;
using Key = std::unique_ptr<EVP_PKEY, Freed<EVP_PKEY, EVP_PKEY_free>>;
using Signed = std::unique_ptr<PKCS7, Freed<PKCS7, PKCS7_free>>;
using Store = std::unique_ptr<X509_STORE, Freed<X509_STORE, X509_STORE_free>>;
using Bytes = std::unique_ptr<BIO, Freed<BIO, BIO_free_all>>;
using Time = std::unique_ptr<ASN1_TIME, Freed<ASN1_TIME, ASN1_TIME_free>>;

constexpr const char* kMakeAnother =
    "; 'palpate-identities add' makes another, of the authority that the others have";

[[noreturn]] void Refuse(const fs::path& file, const std::string& what) {
  throw Error("--identity: " + file.string() + what);
}

/// Size limit of each file of an identity; certificates, keys and signed permissions have a few kB.
constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 20;

/// Reads a file.  It must be regular, because Cyclone DDS opens it again by name, and would block
/// on a pipe.
Bytes Open(const fs::path& file, const FileCheck& check = {}) {
  if (access(file.c_str(), R_OK) != 0) {
    Refuse(file, std::string(": ") + std::strerror(errno) +
                     "; 'palpate-identities add' makes a folder with all that belongs to one");
  }
  const std::string content = ReadWholeFile(file.string(), kMostBytes, "--identity:", check);
  Bytes bytes(BIO_new(BIO_s_mem()));
  BIO_set_mem_eof_return(bytes.get(), 0);
  if (BIO_write(bytes.get(), content.data(), static_cast<int>(content.size())) !=
      static_cast<int>(content.size())) {
    Refuse(file, content.empty() ? ": is empty" : ": there is no memory for it");
  }
  return bytes;
}

Certificate ReadCertificate(const fs::path& file) {
  Certificate certificate(PEM_read_bio_X509(Open(file).get(), nullptr, nullptr, nullptr));
  if (!certificate) Refuse(file, std::string(" has no certificate (PEM)") + kMakeAnother);
  return certificate;
}

Key ReadKey(const fs::path& file) {
  const Bytes bytes = Open(file, [&](const struct stat& status) {
    if ((status.st_mode & (S_IRWXG | S_IRWXO)) != 0) {
      Refuse(file, " may be read by others, who could then impersonate this program; chmod 600 it");
    }
  });
  // Without a callback OpenSSL would ask for a password on the terminal.
  Key key(PEM_read_bio_PrivateKey(
      bytes.get(), nullptr, [](char*, int, int, void*) { return -1; }, nullptr));
  if (!key) {
    Refuse(file, std::string(" has no private key (PEM) without a password") + kMakeAnother);
  }
  return key;
}

std::string Utc(std::time_t time) {
  return fmt::format("{:%F %T} UTC", fmt::gmtime(time));
}

/// A period of validity [s since 1970].
struct Span {
  std::time_t begin, end;
};

/// @param what  what is valid in that period: "the certificate".
void SeeThatItHolds(const fs::path& file, const std::string& what, const Span& span,
                    std::time_t now) {
  if (now < span.begin) {
    Refuse(file, ": " + what + " is valid from " + Utc(span.begin) +
                     " on, but by this host's clock " + "it is " + Utc(now) +
                     "; set the clock, of this host or of the one where " +
                     "the identity was made");
  }
  if (now > span.end) {
    Refuse(file, ": " + what + " has expired: it was valid until " + Utc(span.end) +
                     ", and by this host's clock it is " + Utc(now) +
                     "; make a new one with 'palpate-identities', or set the clock");
  }
}

std::time_t Seconds(const ASN1_TIME* time) {
  std::tm parts{};
  if (ASN1_TIME_to_tm(time, &parts) != 1) throw Error("a certificate's date cannot be read");
  return timegm(&parts);
}

void SeeThatItHolds(const fs::path& file, const X509* certificate, std::time_t now) {
  SeeThatItHolds(
      file, "the certificate",
      {Seconds(X509_get0_notBefore(certificate)), Seconds(X509_get0_notAfter(certificate))}, now);
}

/// Returns the document in a signed file after verifying the authority's signature.
std::string ReadSigned(const fs::path& file, const fs::path& authority, X509* certificate) {
  BIO* found = nullptr;
  const Signed document(SMIME_read_PKCS7(Open(file).get(), &found));
  const Bytes content(found);
  if (!document) Refuse(file, std::string(" is not a signed document (S/MIME)") + kMakeAnother);
  const Store store(X509_STORE_new());
  X509_STORE_add_cert(store.get(), certificate);
  // Dates are checked elsewhere, with clearer messages.  The given authority is accepted for
  // any purpose.
  X509_VERIFY_PARAM* const terms = X509_STORE_get0_param(store.get());
  X509_VERIFY_PARAM_set_flags(terms, X509_V_FLAG_NO_CHECK_TIME);
  X509_VERIFY_PARAM_set_purpose(terms, X509_PURPOSE_ANY);
  const Bytes text(BIO_new(BIO_s_mem()));
  if (PKCS7_verify(document.get(), nullptr, store.get(), content.get(), text.get(), PKCS7_TEXT) !=
      1) {
    Refuse(file, " is not what " + authority.string() +
                     " signed: it was changed, or is from another authority" + kMakeAnother);
  }
  char* data = nullptr;
  const long size = BIO_get_mem_data(text.get(), &data);
  return {data, static_cast<std::size_t>(std::max(size, 0L))};
}

/// Splits "CN=left,O=palpate" into its parts, whose order does not matter.
std::set<std::string> PartsOf(const std::string& name) {
  static const std::regex kPart(R"(\s*([^,]*[^,\s])\s*)");
  std::set<std::string> parts;
  for (std::sregex_iterator it(name.begin(), name.end(), kPart), end; it != end; ++it) {
    parts.insert((*it)[1]);
  }
  return parts;
}

std::string SubjectOf(X509* certificate) {
  const Bytes text(BIO_new(BIO_s_mem()));
  X509_NAME_print_ex(text.get(), X509_get_subject_name(certificate), 0, XN_FLAG_RFC2253);
  char* data = nullptr;
  const long size = BIO_get_mem_data(text.get(), &data);
  return {data, static_cast<std::size_t>(std::max(size, 0L))};
}

/// Returns the text between two others, searched from `at` on, and moves `at` behind both; nullopt
/// if there is none.
std::optional<std::string> Between(const std::string& text, const std::string& begin,
                                   const std::string& end, std::size_t& at) {
  const std::size_t first = text.find(begin, at);
  if (first == std::string::npos) return std::nullopt;
  const std::size_t last = text.find(end, first + begin.size());
  if (last == std::string::npos) return std::nullopt;
  at = last + end.size();
  return text.substr(first + begin.size(), last - first - begin.size());
}

std::optional<std::string> Element(const std::string& xml, const std::string& name) {
  std::size_t at = 0;
  return Between(xml, "<" + name + ">", "</" + name + ">", at);
}

std::string WithoutComments(const std::string& xml) {
  std::string text;
  for (std::size_t at = 0, end = 0; at != std::string::npos; at = end) {
    const std::size_t begin = xml.find("<!--", at);
    text += xml.substr(at, begin - at);
    end = begin == std::string::npos ? begin : xml.find("-->", begin);
    if (end != std::string::npos) end += 3;
  }
  return text;
}

/// Parses a date of XML Schema, 2026-11-25T13:00:00, with Z, an offset, or neither (UTC).
std::optional<std::time_t> DateIn(const std::string& xml, const std::string& name) {
  const std::optional<std::string> text = Element(xml, name);
  if (!text) return std::nullopt;
  static const std::regex kDate(R"(\s*(\S+?)(?:\.\d+)?(?:Z|([+-])(\d\d):(\d\d))?\s*)");
  std::smatch match;
  std::tm parts{};
  if (!std::regex_match(*text, match, kDate)) return std::nullopt;
  const std::string moment = match[1];
  const char* const end = strptime(moment.c_str(), "%Y-%m-%dT%H:%M:%S", &parts);
  if (end == nullptr || *end != '\0') return std::nullopt;
  std::time_t offset = 0;
  if (match[2].matched) {
    offset = 60 * (60 * std::stoi(match[3]) + std::stoi(match[4])) * (match[2] == "-" ? -1 : 1);
  }
  return timegm(&parts) - offset;
}

void CheckPermissions(const fs::path& file, const std::string& document, X509* certificate,
                      std::time_t now) {
  const std::string xml = WithoutComments(document);
  const std::string subject = SubjectOf(certificate);
  std::size_t at = 0;
  while (const std::optional<std::string> found = Between(xml, "<grant", "</grant>", at)) {
    const std::string& grant = *found;
    const std::optional<std::string> whose = Element(grant, "subject_name");
    if (!whose || PartsOf(*whose) != PartsOf(subject)) continue;
    const auto begins = DateIn(grant, "not_before");
    const auto ends = DateIn(grant, "not_after");
    if (!begins || !ends) {
      Refuse(file, std::string(" does not state its validity") + kMakeAnother);
    }
    return SeeThatItHolds(file, "the permission", {*begins, *ends}, now);
  }
  Refuse(file, " has no permissions for '" + Printable(subject) +
                   "', whose certificate is beside it: it is from another identity" + kMakeAnother);
}

/// Checks that messages or submessages are authenticated.  Otherwise an attacker without an
/// identity could send a captured sample again, with a new sequence number.
void CheckGovernance(const fs::path& file, const std::string& document) {
  const std::string xml = WithoutComments(document);
  const auto leaves = [&](const std::string& what) {
    return std::regex_search(xml, std::regex("<" + what + R"(_protection_kind>\s*NONE\s*<)"));
  };
  if (!leaves("rtps") || !leaves("metadata")) return;
  Refuse(file,
         ": these rules, of an earlier version, do not prevent replayed messages; run "
         "'palpate-identities renew FOLDER' on the host of FOLDER/authority, and copy all "
         "FOLDER/identities to their hosts again");
}

}  // namespace

void CheckIdentity(const std::string& identity, std::time_t now) {
  const fs::path folder(identity);
  const fs::path authority = folder / "identity_ca.pem", own = folder / "cert.pem",
                 signer = folder / "permissions_ca.pem", key_file = folder / "key.pem";
  const Key key = ReadKey(key_file);
  const Certificate certificate = ReadCertificate(own), issuer = ReadCertificate(authority),
                    permitter = ReadCertificate(signer);
  if (X509_check_private_key(certificate.get(), key.get()) != 1) {
    Refuse(key_file, " is not the key of " + own.string() +
                         ": two identities are mixed; copy the whole folder again");
  }
  if (X509_verify(certificate.get(), X509_get0_pubkey(issuer.get())) != 1) {
    Refuse(own, " is not issued by " + authority.string() +
                    ": files of two authorities are mixed; copy the whole folder again");
  }
  SeeThatItHolds(own, certificate.get(), now);
  SeeThatItHolds(authority, issuer.get(), now);
  SeeThatItHolds(signer, permitter.get(), now);
  const fs::path governance = folder / "governance.p7s";
  CheckGovernance(governance, ReadSigned(governance, signer, permitter.get()));
  const fs::path permissions = folder / "permissions.p7s";
  CheckPermissions(permissions, ReadSigned(permissions, signer, permitter.get()), certificate.get(),
                   now);
}

}  // namespace palpate::dds
