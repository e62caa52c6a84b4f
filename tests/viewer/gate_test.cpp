#include "client/viewer/gate.h"

#include <gmock/gmock.h>

#include "tests/support/folder.h"

namespace palpate {
namespace {

using testing::HasSubstr;

constexpr std::string_view kHost = "127.0.0.1:8765";

TEST(Access, IsWhatThePagesOriginAllows) {
  struct Case {
    const char* origin;
    Access access;
    const char* host = "127.0.0.1:8765";
    std::vector<std::string> allowed = {};
    bool in_the_clear = true;
    bool over_tls = true;
  };
  const std::vector<std::string> app = {"https://other", "https://app.example.org"};
  const Case cases[] = {
      // This gateway's own pages, and programs.
      {"", Access::kOperate},
      {"https://127.0.0.1:8765", Access::kOperate},
      {"http://127.0.0.1:8765", Access::kOperate, "127.0.0.1:8765", {}, true, false},
      {"http://LocalHost:8765", Access::kOperate, "localhost:8765", {}, true, false},
      {"http://[::1]:8765", Access::kOperate, "[::1]:8765", {}, true, false},
      {"https://lab.example", Access::kOperate, "lab.example"},  // a proxy may speak TLS
      // Anybody on the network path could have written that page.
      {"http://127.0.0.1:8765", Access::kNone, "127.0.0.1:8765", {}, false},
      // Pages from elsewhere.
      {"http://evil.example", Access::kNone},
      {"http://127.0.0.1:9999", Access::kNone},
      {"http://127.0.0.1:8765.evil.example", Access::kNone},
      {"null", Access::kNone},
      {"null", Access::kNone, "null"},
      {"http://", Access::kNone, "", {"http://app.example"}},
      {"127.0.0.1:8765", Access::kNone},
      {"file://evil.example", Access::kNone},
      {"file:///", Access::kNone},
      {"ftp://127.0.0.1:8765", Access::kNone},
      {"http://127.0.0.1:8765/", Access::kNone},
      {"http://a@127.0.0.1:8765", Access::kNone},
      {"http://127.0.0.1", Access::kNone},
      {"https://app.example.org.evil", Access::kNone, "127.0.0.1:8765", app},
      // Desktop applications, and pages named in --allow-origin.
      {"file://", Access::kWatch},
      {"FILE://", Access::kWatch, "lab.example"},
      {"file://", Access::kDrive, "127.0.0.1:8765", {"file://"}},
      {"https://app.example.org", Access::kDrive, "127.0.0.1:8765", app},
      {"https://anything", Access::kDrive, "127.0.0.1:8765", {"*"}}};
  for (const Case& of : cases) {
    for (const bool secure : {false, true}) {
      if (!(secure ? of.over_tls : of.in_the_clear)) continue;
      EXPECT_EQ(AccessOfOrigin(of.origin, of.host, secure, of.allowed), of.access)
          << of.origin << " at " << of.host << (secure ? " over TLS" : "");
    }
  }
}

class GateTest : public testing::Test {
 protected:
  GateTest() {
    watch_ = MakeToken(path_, Access::kWatch, "class");
    drive_ = MakeToken(path_, Access::kDrive, "hand");
    operate_ = MakeToken(path_, Access::kOperate, "teacher");
    guarded_.emplace(kOptions, Tokens::Read(path_));
  }

  static Asker Plain(bool is_local = true) {
    Asker asker;
    asker.host = kHost;
    asker.hosts = 1;
    asker.is_local = is_local;
    return asker;
  }
  /// A token as programs present it.
  static Asker With(const std::string& authorization) {
    Asker asker = Plain();
    asker.authorization = authorization;
    asker.authorizations = 1;
    return asker;
  }

  static inline const Gate::Options kOptions{{"lab.example"}, {"https://app.example"}};
  const test::Folder folder_;
  const std::string path_ = folder_ / "tokens";
  std::string watch_, drive_, operate_;
  Gate open_{kOptions, std::nullopt};
  std::optional<Gate> guarded_;
};

TEST_F(GateTest, LetsInWhoNamesAHostOfThisGatewayAndSaysHowToNameAnother) {
  for (const Gate* gate : {&open_, &*guarded_}) {
    Asker asker = Plain();
    EXPECT_NE(gate->JudgeHost(asker).access, Access::kNone);
    asker.host = "lab.example:8765";
    EXPECT_NE(gate->JudgeHost(asker).access, Access::kNone);
    asker.host = "evil.example";
    const Verdict verdict = gate->JudgeHost(asker);
    EXPECT_EQ(verdict.access, Access::kNone);
    EXPECT_EQ(verdict.status, 421);
    EXPECT_EQ(verdict.refusal, Refusal::kHost);
    EXPECT_THAT(verdict.reason,
                testing::AllOf(HasSubstr("'evil.example'"), HasSubstr("--host-name")));
    for (const int hosts : {0, 2}) {
      asker = Plain();
      asker.hosts = hosts;
      EXPECT_EQ(gate->JudgeHost(asker).status, 400);
    }
  }
}

TEST_F(GateTest, WithoutTokensGivesTheHostItselfAllAndOthersTheMouse) {
  EXPECT_EQ(open_.JudgeSocket(Plain(true)).access, Access::kOperate);
  EXPECT_EQ(open_.JudgeSocket(Plain(false)).access, Access::kDrive);
  EXPECT_NE(open_.JudgeToken(Plain(false)).access, Access::kNone);
}

TEST_F(GateTest, GivesEachTokenItsRoleWhereverItIsPresented) {
  for (const auto& [token, role, name] :
       {std::tuple(watch_, Access::kWatch, "class"), std::tuple(drive_, Access::kDrive, "hand"),
        std::tuple(operate_, Access::kOperate, "teacher")}) {
    for (const bool is_local : {true, false}) {
      const std::string header = "bEARER  " + token;
      Asker asker = With(header);
      asker.is_local = is_local;
      EXPECT_EQ(guarded_->JudgeSocket(asker).access, role);
      EXPECT_EQ(guarded_->JudgeToken(asker).holder->name, name);
      asker = Plain(is_local);
      const std::string offered = "foxglove.sdk.v1,\tpalpate.token." + token + " , other";
      asker.subprotocols = offered;
      EXPECT_EQ(guarded_->JudgeSocket(asker).access, role);
    }
  }
}

TEST_F(GateTest, GivesAPageNoMoreThanItsTokenAndNoMoreThanItsOrigin) {
  const std::string header = "Bearer " + operate_;
  Asker asker = With(header);
  asker.origin = "https://app.example";
  EXPECT_EQ(guarded_->JudgeSocket(asker).access, Access::kDrive);
  asker.origin = "file://";
  EXPECT_EQ(guarded_->JudgeSocket(asker).access, Access::kWatch);
  asker.origin = "http://evil.example";
  EXPECT_EQ(guarded_->JudgeSocket(asker).access, Access::kNone);
  EXPECT_EQ(guarded_->JudgeSocket(asker).refusal, Refusal::kOrigin);
}

TEST_F(GateTest, RefusesAllElseAndTellsNobodyWhatWasPresented) {
  std::string slip = operate_;
  slip.back() = slip.back() == '0' ? '1' : '0';
  const std::string two = "palpate.token." + operate_ + ", palpate.token." + watch_;
  const std::string twice = "palpate.token." + operate_ + ", palpate.token." + operate_;
  const std::string cut = "palpate.token." + operate_.substr(0, 40);
  for (const std::string& header :
       {std::string("Bearer " + slip), std::string("Bearer"), std::string("Bearer "), operate_,
        "Basic " + operate_, "Bearer " + operate_ + " " + watch_, "Bearer " + operate_ + ",",
        "Bearer\"" + operate_ + "\"", std::string("Bearer ") + std::string(8000, 'a'),
        "Bearer palpate_" + std::string(64, '0')}) {
    const Verdict verdict = guarded_->JudgeSocket(With(header));
    EXPECT_EQ(verdict.access, Access::kNone) << header.substr(0, 100);
    EXPECT_EQ(verdict.status, 401) << header.substr(0, 100);
    EXPECT_EQ(verdict.refusal, Refusal::kToken);
    EXPECT_THAT(verdict.reason, testing::Not(HasSubstr(operate_.substr(8, 20))));
    EXPECT_THAT(verdict.reason, testing::Not(HasSubstr("aaaa")));
    EXPECT_EQ(guarded_->JudgeToken(With(header)).access, Access::kNone);
  }
  for (const std::string& offered : {two, twice, cut, std::string("palpate.token."),
                                     "palpate.token.palpate.token." + operate_, operate_}) {
    Asker asker = Plain();
    asker.subprotocols = offered;
    EXPECT_EQ(guarded_->JudgeSocket(asker).access, Access::kNone) << offered;
  }
  // A token in each of two places, though both are good.
  const std::string header = "Bearer " + operate_;
  const std::string offered = "palpate.token." + operate_;
  Asker asker = With(header);
  asker.subprotocols = offered;
  EXPECT_EQ(guarded_->JudgeSocket(asker).status, 400);
  asker = With(header);
  asker.authorizations = 2;
  EXPECT_EQ(guarded_->JudgeSocket(asker).status, 400);
  EXPECT_EQ(guarded_->JudgeSocket(Plain()).status, 401);
}

}  // namespace
}  // namespace palpate
