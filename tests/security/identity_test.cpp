#include "common/dds/identity.h"

#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <memory>
#include <string>

#include <gmock/gmock.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include "common/dds/security.h"
#include "common/error.h"
#include "tests/security/authority.h"

namespace palpate::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
namespace fs = std::filesystem;

constexpr std::time_t kDay = 86'400;

/// The error that refuses an identity; empty: it is accepted.
std::string Refusal(const fs::path& identity, std::time_t now = std::time(nullptr)) {
  try {
    dds::CheckIdentity(identity, now);
    return "";
  } catch (const Error& error) {
    return error.what();
  }
}

std::string Read(const fs::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

void OpenSsl(std::vector<std::string> arguments) {
  Program openssl("/usr/bin/openssl", std::move(arguments));
  ASSERT_EQ(openssl.Exit(30.0), 0) << openssl.Output();
}

/// Changes a document of the identity and has the authority sign it, as the script does.
void SignAnew(const Authority& authority, const fs::path& document,
              const std::function<void(std::string&)>& change) {
  const fs::path plain = document.string() + ".xml";
  OpenSsl({"smime", "-verify", "-noverify", "-text", "-in", document, "-out", plain});
  std::string text = Read(plain);
  change(text);
  std::ofstream(plain) << text;
  OpenSsl({"smime", "-sign", "-text", "-in", plain, "-out", document, "-signer",
           authority.keys() / "permissions_ca.pem", "-inkey",
           authority.keys() / "permissions_ca_key.pem"});
}

void CopyOver(const fs::path& from, const fs::path& to) {
  fs::copy(from, to, fs::copy_options::overwrite_existing);
}

void Replace(std::string& text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  ASSERT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
}

/// Gives a certificate other dates, signed by its authority.
void Date(const fs::path& certificate, const fs::path& authority_key, long from_s, long until_s) {
  const auto open = [](const fs::path& file, const char* mode) {
    return std::unique_ptr<std::FILE, int (*)(std::FILE*)>(std::fopen(file.c_str(), mode),
                                                           &std::fclose);
  };
  X509* const read = PEM_read_X509(open(certificate, "r").get(), nullptr, nullptr, nullptr);
  EVP_PKEY* const key =
      PEM_read_PrivateKey(open(authority_key, "r").get(), nullptr, nullptr, nullptr);
  ASSERT_TRUE(read != nullptr && key != nullptr);
  X509_gmtime_adj(X509_getm_notBefore(read), from_s);
  X509_gmtime_adj(X509_getm_notAfter(read), until_s);
  ASSERT_GT(X509_sign(read, key, EVP_sha256()), 0);
  ASSERT_EQ(PEM_write_X509(open(certificate, "w").get(), read), 1);
  X509_free(read);
  EVP_PKEY_free(key);
}

class IdentityTest : public testing::Test {
 protected:
  static const Authority& Lab() {
    static const Authority authority("identity");
    return authority;
  }
  static std::string Today() {
    const std::time_t now = std::time(nullptr);
    char text[16];
    std::strftime(text, sizeof text, "%Y-%m-%d", std::gmtime(&now));
    return text;
  }
  ~IdentityTest() override { fs::remove_all(own_); }

  const fs::path own_ = Lab().Add("station", "left");
};

TEST_F(IdentityTest, IsTakenAsTheScriptMakesIt) {
  EXPECT_EQ(Refusal(own_), "");
  EXPECT_THAT(dds::SecurityConfig(own_), HasSubstr("key.pem"));
}

TEST_F(IdentityTest, NamesEachFileThatItLacksOrThatHoldsSomethingElse) {
  for (const char* file : {"key.pem", "cert.pem", "identity_ca.pem", "permissions_ca.pem",
                           "governance.p7s", "permissions.p7s"}) {
    const std::string path = own_ / file, before = Read(path);
    fs::rename(path, own_ / "away");
    EXPECT_THAT(Refusal(own_),
                AllOf(HasSubstr(path + ": No such file"), HasSubstr("palpate-identities add")));
    fs::rename(own_ / "away", path);
    std::ofstream(path) << "nothing of the kind\n";
    EXPECT_THAT(Refusal(own_), HasSubstr(path + " ")) << file;
    std::ofstream(path) << before;
  }
  EXPECT_EQ(Refusal(own_), "");
}

TEST_F(IdentityTest, KeepsItsKeyFromOthers) {
  for (const fs::perms others : {fs::perms::group_read, fs::perms::others_read}) {
    fs::permissions(own_ / "key.pem", fs::perms::owner_read | fs::perms::owner_write | others);
    EXPECT_THAT(Refusal(own_),
                AllOf(HasSubstr("key.pem may be read by others"), HasSubstr("chmod 600")));
  }
  fs::permissions(own_ / "key.pem", fs::perms::owner_read);
  EXPECT_EQ(Refusal(own_), "");
}

TEST_F(IdentityTest, IsAskedForNoPassword) {
  OpenSsl({"pkcs8", "-topk8", "-in", own_ / "key.pem", "-out", own_ / "locked.pem", "-passout",
           "pass:secret"});
  fs::rename(own_ / "locked.pem", own_ / "key.pem");
  fs::permissions(own_ / "key.pem", fs::perms::owner_read);
  EXPECT_THAT(Refusal(own_), HasSubstr("without a password"));
}

TEST_F(IdentityTest, NeedsTheKeyOfItsCertificate) {
  const fs::path other = Lab().Add("station", "other");
  CopyOver(other / "key.pem", own_ / "key.pem");
  fs::remove_all(other);
  EXPECT_THAT(Refusal(own_), AllOf(HasSubstr("key.pem is not the key of " + own_.string()),
                                   HasSubstr("copy the whole folder again")));
}

TEST_F(IdentityTest, NeedsACertificateOfItsAuthority) {
  const Authority elsewhere("identity_elsewhere");
  CopyOver(elsewhere.keys() / "identity_ca.pem", own_ / "identity_ca.pem");
  EXPECT_THAT(Refusal(own_), AllOf(HasSubstr("cert.pem is not issued by " + own_.string()),
                                   HasSubstr("identity_ca.pem")));
}

TEST_F(IdentityTest, SaysWhenItsCertificateBeginsAndEndsToHold) {
  const fs::path key = Lab().keys() / "identity_ca_key.pem";
  Date(own_ / "cert.pem", key, -10 * kDay, -1);
  EXPECT_THAT(
      Refusal(own_),
      AllOf(HasSubstr("cert.pem: the certificate has expired: it was valid until " + Today()),
            HasSubstr("make a new one")));
  Date(own_ / "cert.pem", key, 3600, 10 * kDay);
  EXPECT_THAT(Refusal(own_), AllOf(HasSubstr("cert.pem: the certificate is valid from "),
                                   HasSubstr("set the clock")));
  Date(own_ / "cert.pem", key, -1, 10 * kDay);
  EXPECT_EQ(Refusal(own_), "");
}

TEST_F(IdentityTest, SaysWhichAuthorityHasExpired) {
  Date(own_ / "identity_ca.pem", Lab().keys() / "identity_ca_key.pem", -10 * kDay, -1);
  EXPECT_THAT(Refusal(own_), HasSubstr("identity_ca.pem: the certificate has expired"));
  CopyOver(Lab().keys() / "identity_ca.pem", own_ / "identity_ca.pem");
  Date(own_ / "permissions_ca.pem", Lab().keys() / "permissions_ca_key.pem", -10 * kDay, -1);
  EXPECT_THAT(Refusal(own_), HasSubstr("permissions_ca.pem: the certificate has expired"));
}

TEST_F(IdentityTest, GoesByTheClockThatItIsGiven) {
  const std::time_t now = std::time(nullptr);
  EXPECT_THAT(Refusal(own_, now + 826 * kDay), HasSubstr("has expired"));
  EXPECT_THAT(Refusal(own_, now - 2 * kDay), HasSubstr("the certificate is valid from"));
}

TEST_F(IdentityTest, SaysWhenItsPermissionBeginsAndEndsToHold) {
  const fs::path file = own_ / "permissions.p7s";
  const auto dates = [&](const std::string& from, const std::string& until) {
    SignAnew(Lab(), file, [&](std::string& xml) {
      const std::size_t at = xml.find("<validity>"), end = xml.find("</validity>");
      ASSERT_NE(end, std::string::npos);
      xml.replace(
          at, end - at,
          "<validity><not_before>" + from + "</not_before><not_after>" + until + "</not_after>");
    });
  };
  dates("2020-01-01T00:00:00", "2021-02-03T04:05:06");
  EXPECT_THAT(Refusal(own_), HasSubstr("permissions.p7s: the permission has expired: it was valid "
                                       "until 2021-02-03 04:05:06 UTC"));
  dates("2020-01-01T00:00:00Z", "2021-02-03T04:05:06+02:00");
  EXPECT_THAT(Refusal(own_), HasSubstr("until 2021-02-03 02:05:06 UTC"));
  dates("2200-01-01T00:00:00", "2201-01-01T00:00:00");
  EXPECT_THAT(Refusal(own_), HasSubstr("the permission is valid from 2200-01-01 00:00:00 UTC on"));
  dates("2020-01-01T00:00:00", "2200-01-01T00:00:00");
  EXPECT_EQ(Refusal(own_), "");
  dates("soon", "later");
  EXPECT_THAT(Refusal(own_), HasSubstr("does not state its validity"));
}

TEST_F(IdentityTest, NeedsAPermissionOfItsOwn) {
  const fs::path other = Lab().Add("gateway", "other");
  CopyOver(other / "permissions.p7s", own_ / "permissions.p7s");
  fs::remove_all(other);
  EXPECT_THAT(Refusal(own_),
              HasSubstr("permissions.p7s has no permissions for 'CN=left,O=palpate'"));
}

TEST_F(IdentityTest, NeedsDocumentsThatNobodyHasChanged) {
  for (const char* file : {"permissions.p7s", "governance.p7s"}) {
    const std::string before = Read(own_ / file);
    std::string changed = before;
    Replace(changed, "<max>229</max>", "<max>228</max>");
    std::ofstream(own_ / file) << changed;
    EXPECT_THAT(Refusal(own_), HasSubstr((own_ / file).string() + " is not what "));
    std::ofstream(own_ / file) << before;
  }
  const Authority elsewhere("identity_elsewhere");
  CopyOver(elsewhere.keys() / "permissions_ca.pem", own_ / "permissions_ca.pem");
  EXPECT_THAT(Refusal(own_), HasSubstr("is from another authority"));
}

TEST_F(IdentityTest, NeedsRulesByWhichNothingCanBeSentAgain) {
  SignAnew(Lab(), own_ / "governance.p7s", [](std::string& xml) {
    Replace(xml, "<metadata_protection_kind>ENCRYPT<", "<metadata_protection_kind>NONE<");
  });
  EXPECT_THAT(Refusal(own_), AllOf(HasSubstr("governance.p7s: these rules, of an earlier version"),
                                   HasSubstr("palpate-identities renew FOLDER")));
  Lab().Script({"renew", own_.parent_path().parent_path()});
  EXPECT_EQ(Refusal(own_), "");
}

TEST_F(IdentityTest, IsRefusedByTheProgramInTheSameWords) {
  Date(own_ / "cert.pem", Lab().keys() / "identity_ca_key.pem", -10 * kDay, -1);
  Program station(OwnFolder() + "/palpate-station",
                  {"--device", "simulated", "--scene", "cube", "--id", "left", "--identity", own_});
  EXPECT_EQ(station.Exit(30.0), 1);
  EXPECT_THAT(station.Output(),
              HasSubstr("cert.pem: the certificate has expired: it was valid until "));
}

TEST(Identity, SaysWhichFoldersNamesAreNotForDds) {
  const Authority authority("<a> & ${HOME}");
  try {
    dds::SecurityConfig(authority.Add("viewer", "far"));
    FAIL() << "DDS would read another text";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("DDS accepts no path with < & $ or"));
  }
}

}  // namespace
}  // namespace palpate::test
