#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <utility>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "client/viewer/topic_feed.h"
#include "tests/viewer/gateway.h"

// The pages of a course's people, as far as tests of the gateway need them.
namespace palpate::test {

using CourseJson = nlohmann::json;

inline std::string FirstLink(Gateway& gateway) {
  const std::string& said = gateway.program().Output();
  const std::size_t begin = said.find("#token=");
  if (begin == said.npos) return "";
  return said.substr(begin + 7, said.find('\n', begin) - begin - 7);
}

/// A person's page.
class Pupil {
 public:
  Pupil(Gateway& gateway, const std::string& token)
      : client_(gateway.port(), kV1, "", 0, {{"Authorization", "Bearer " + token}}) {
    client_.Subscribe(1, TopicFeed::kMe);
    client_.Subscribe(5, TopicFeed::kTrial);
  }
  WebClient& client() { return client_; }
  /// The next message about the person.
  CourseJson Me() { return Read(1); }
  /// The next message about an exam.
  CourseJson Exam() {
    if (!std::exchange(hears_exam_, true)) client_.Subscribe(4, TopicFeed::kExam);
    return Read(4);
  }
  /// The next message about the person's trial.
  CourseJson Trial() { return Read(5); }
  /// Hears its trials until one is in one of these phases.
  bool Comes(const std::set<std::string>& phases) {
    return Eventually([&] {
      const CourseJson trial = Read(5);
      return trial.is_object() && phases.contains(trial["phase"]);
    });
  }
  /// The answer to taking a scene with the mouse.
  std::string Take(const std::string& scene) {
    client_.SendMouse({{"op", "take"}, {"scene", scene}});
    client_.Subscribe(3, TopicFeed::kMouseState);
    return Read(3).dump();
  }

 protected:
  CourseJson Read(std::uint32_t subscription) {
    const auto message = client_.Next(subscription);
    if (!message) return {};
    return CourseJson::parse(message->payload.begin(), message->payload.end());
  }
  WebClient client_;
  bool hears_exam_ = false;
};

class Teacher : public Pupil {
 public:
  Teacher(Gateway& gateway, const std::string& token) : Pupil(gateway, token), token_(token) {
    client_.Subscribe(2, TopicFeed::kClassAnswer);
  }
  CourseJson Ask(CourseJson wish) {
    wish["tag"] = ++tag_;
    client_.SendClass(wish);
    CourseJson answer = Read(2);
    EXPECT_EQ(answer["tag"], tag_);
    return answer;
  }
  std::string Refusal(CourseJson wish) { return Ask(std::move(wish))["refusal"]; }
  const std::string& token() const { return token_; }
  std::string Make(const std::string& name) {
    return Ask({{"op", "person_make"}, {"names", {name}}, {"role", "drive"}})["people"][0]["token"];
  }

 private:
  const std::string token_;
  int tag_ = 0;
};

}  // namespace palpate::test
