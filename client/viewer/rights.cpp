#include "client/viewer/rights.h"

#include <utility>

#include <spdlog/spdlog.h>

#include "common/error.h"

namespace palpate {

Rights::Rights(const ViewerOptions& options, Viewers& viewers,
               std::function<void(std::uint64_t, const std::string&)> take_back)
    : options_(options),
      viewers_(viewers),
      take_back_(std::move(take_back)),
      class_room_(options.course.empty() ? nullptr : std::make_unique<ClassRoom>(options.course)),
      listed_(options.tokens.empty() ? std::nullopt : std::optional(Tokens::Read(options.tokens))),
      gate_({options.host_names, options.origins},
            class_room_ ? class_room_->With(listed()) : listed_) {}

bool Rights::ReadAnew() try {
  if (!options_.asks_for_tokens()) {
    spdlog::info("there are no --tokens and no --course to read again");
    return false;
  }
  if (class_room_) class_room_->roster().Read();
  const std::size_t ended =
      Renew(options_.tokens.empty() ? std::nullopt : std::optional(Tokens::Read(options_.tokens)));
  spdlog::info("{} read again: {} tokens are valid; connections closed: {}",
               options_.tokens + options_.course, gate_.tokens()->size(), ended);
  return true;
} catch (const Error& error) {
  spdlog::error("{}; the tokens read before remain valid", error.what());
  return false;
}

std::size_t Rights::Renew(std::optional<Tokens> listed) {
  gate_.Replace(class_room_ ? class_room_->With(listed.value_or(Tokens())) : *listed);
  listed_ = std::move(listed);
  std::size_t ended = 0;
  const auto viewers = viewers_.all();
  for (const auto& [id, viewer] : viewers) {
    const auto& holder = viewer->guest().holder;
    if (holder && gate_.tokens()->Has(*holder)) continue;
    if (class_room_ && holder) {
      // After a mere change of name the viewer continues, with the tool in the hand.
      const Person* const person = class_room_->roster().Find(holder->person);
      if (person != nullptr && person->hash == holder->hash && person->role == holder->role) {
        viewer->Rename(person->name, person->station);
        continue;
      }
    }
    ++ended;
    take_back_(id, "its token was taken back");
    viewer->Say(foxglove::Level::kError,
                "this connection ends: its token was taken back, or has another role now");
    viewer->Close(boost::beast::websocket::close_code::policy_error, "its token was taken back");
  }
  return ended;
}

std::optional<Roster::Made> Rights::MakeFirstTeacher() {
  if (!class_room_) return std::nullopt;
  auto teacher = class_room_->MakeFirstTeacher();
  if (teacher) Renew();
  return teacher;
}

}  // namespace palpate
