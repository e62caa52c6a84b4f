#include "client/replayer/certificate/certificate.h"

#include <algorithm>
#include <ctime>
#include <filesystem>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>

#include "client/replayer/score/score_plot.h"
#include "client/replayer/score/score_words.h"
#include "common/error.h"
#include "common/files/output.h"
#include "common/revision.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;
using Lines = std::vector<std::string>;

/// The texts of a certificate in one language.
class Words {
 public:
  explicit Words(std::size_t at) : all_(Json::parse(kCertificateCatalogues.at(at).second)) {}
  /// @param values  fmt::arg for each name in braces.
  template <class... Values>
  std::string operator()(const char* key, const Values&... values) const {
    return fmt::format(fmt::runtime(all_.at(key).get_ref<const std::string&>()), values...);
  }
  Lines List(const char* key) const { return all_.at(key).get<Lines>(); }

 private:
  Json all_;
};

const Words& English() {
  static const Words words(0);
  return words;
}

std::string WhenText(std::int64_t s) {
  return fmt::format("{:%F %T} UTC", fmt::gmtime(static_cast<std::time_t>(s)));
}

std::string PageName(std::size_t at) {
  return at == 0 ? "certificate.html"
                 : fmt::format("certificate.{}.html", kCertificateCatalogues[at].first);
}

/// Returns a trial's verdict.  Reasons of refusal are in English: they quote files and programs.
std::string VerdictOf(const SealedVerdict& trial, const Words& words) {
  if (!trial.seal || !trial.refused.empty()) return trial.refused;
  std::string text;
  if (trial.seal->recording.empty()) {
    text = words("nothing_recorded");
  } else if (trial.wrenches == 0) {
    text = words("nothing_done");
  } else {
    std::string seconds = fmt::format("{:.1f}", trial.recorded_s);
    std::ranges::replace(seconds, '.', words("decimal_point").front());
    text = words("every_bit", fmt::arg("seconds", seconds), fmt::arg("forces", trial.wrenches));
  }
  if (!trial.seal->whole) text += words("cut_short", fmt::arg("reason", trial.seal->reason));
  if (!trial.counts) text += words("does_not_count");
  return text;
}

std::string Sentence(const Certificate& certificate, const Words& words) {
  const auto good = std::ranges::count_if(
      certificate.trials, [](const SealedVerdict& trial) { return trial.refused.empty(); });
  std::string text = words(certificate.good() ? "verified" : "not_verified", fmt::arg("good", good),
                           fmt::arg("all", certificate.trials.size()));
  if (!certificate.missing.empty()) {
    text += words("so_many_missing", fmt::arg("count", certificate.missing.size()));
  }
  return text;
}

Lines Facts(const Certificate& certificate, const Words& words) {
  const std::optional<Roll>& roll = certificate.roll;
  return {words("exam", fmt::arg("exam", certificate.exam.empty() ? "–" : certificate.exam)),
          words("key", fmt::arg("key", certificate.key)),
          words("by",
                fmt::arg("program",
                         fmt::format("palpate {}, physics {}", PALPATE_VERSION, kPhysicsRevision)),
                fmt::arg("time", WhenText(certificate.verified_s))),
          roll ? words("roll", fmt::arg("trials", roll->trials.size()),
                       fmt::arg("opened", WhenText(roll->opened_s)),
                       fmt::arg("closed", WhenText(roll->closed_s)))
               : words("no_roll")};
}

Json JsonOf(const Certificate& certificate) {
  Json json{{"good", certificate.good()},
            {"exam", certificate.exam},
            {"key", certificate.key},
            {"version", PALPATE_VERSION},
            {"physics", kPhysicsRevision},
            {"verified_s", certificate.verified_s},
            {"took_s", certificate.took_s},
            {"roll", certificate.roll.has_value()},
            {"missing", certificate.missing},
            {"verified", English().List("what_was")},
            {"not_verified", English().List("what_was_not")},
            {"trials", Json::array()}};
  for (const SealedVerdict& trial : certificate.trials) {
    Json one{{"file", trial.file},
             {"refused", trial.refused},
             {"wrenches", trial.wrenches},
             {"recorded_s", trial.recorded_s},
             {"counts", trial.counts}};
    if (const auto& seal = trial.seal) {
      one["person"] = seal->person;
      one["name"] = seal->name;
      one["task"] = seal->task;
      one["exercise"] = seal->exercise;
      one["n"] = seal->n;
      one["recording"] = seal->recording;
      one["sha256"] = seal->sha256;
      one["exercise_sha256"] = seal->exercise_sha256;
      one["criteria_sha256"] = seal->criteria_sha256;
      one["begun_s"] = seal->begun_s;
      one["ended_s"] = seal->ended_s;
      one["whole"] = seal->whole;
      one["reason"] = seal->reason;
    }
    json["trials"].push_back(one);
  }
  return json;
}

constexpr const char* kHead =
    "<!doctype html>\n<html lang=\"{language}\"><meta charset=\"utf-8\"><title>{title}: {exam}"
    "</title><style>{palette}body {{ font: 14px/1.45 system-ui, sans-serif; max-width: 60rem; "
    "margin: 2rem auto; padding: 0 1rem; background: var(--paper); color: var(--ink) }} table {{ "
    "border-collapse: collapse; width: 100% }} th, td {{ text-align: left; padding: .3rem .6rem; "
    "border-bottom: 1px solid var(--line); vertical-align: top }} td:last-child {{ overflow-wrap: "
    "anywhere }} .refused {{ color: var(--alarm) }} a {{ color: inherit }} @media print {{ body {{ "
    "background: #fff; color: #000 }} nav {{ display: none }} }}</style><nav>{languages}</nav>"
    "<h1>{title}</h1><p><b>{sentence}</b></p>";

std::string ListOf(const Lines& lines, const char* attributes = "") {
  std::string list = fmt::format("<ul{}>", attributes);
  for (const std::string& line : lines) list += "<li>" + Escaped(line);
  return list + "</ul>\n";
}

std::string RowOf(const SealedVerdict& trial, const Words& words) {
  const Seal seal = trial.seal.value_or(Seal{});
  const bool good = trial.refused.empty();
  return fmt::format(
      "<tr><td>{}<td>{}<td>{}<td><code>{}</code><td{}>{}: {}\n",
      Escaped(trial.seal ? fmt::format("{} ({})", seal.name, seal.person) : trial.file),
      trial.seal ? fmt::format("{}: {}", seal.task, Escaped(seal.exercise)) : "",
      trial.seal ? WhenText(seal.ended_s) : "", seal.sha256.substr(0, 16),
      good ? "" : " class=\"refused\"", Escaped(words(good ? "trial_verified" : "trial_refused")),
      Escaped(VerdictOf(trial, words)));
}

/// @param at  index of the language.
std::string Html(const Certificate& certificate, std::size_t at) {
  const Words words(at);
  std::string languages;
  for (std::size_t other = 0; other < kCertificateCatalogues.size(); ++other) {
    if (other == at) continue;
    languages +=
        fmt::format("<a href=\"{0}\" lang=\"{1}\" hreflang=\"{1}\">{2}</a> ", PageName(other),
                    kCertificateCatalogues[other].first, Words(other)("language"));
  }
  std::string page =
      fmt::format(fmt::runtime(kHead), fmt::arg("language", kCertificateCatalogues[at].first),
                  fmt::arg("title", words("title")), fmt::arg("exam", Escaped(certificate.exam)),
                  fmt::arg("palette", kScorePagePalette), fmt::arg("languages", languages),
                  fmt::arg("sentence", Escaped(Sentence(certificate, words))));
  page += ListOf(Facts(certificate, words)) + "<table><tr>";
  for (const std::string& column : words.List("columns")) page += "<th>" + column;
  page += "\n";
  for (const SealedVerdict& trial : certificate.trials) page += RowOf(trial, words);
  page += "</table>";
  if (!certificate.missing.empty()) {
    page += fmt::format("<h2>{}</h2>", words("missing")) +
            ListOf(certificate.missing, " class=\"refused\"");
  }
  page += fmt::format("<h2>{}</h2>", words("what_was_title")) + ListOf(words.List("what_was"));
  page +=
      fmt::format("<h2>{}</h2>", words("what_was_not_title")) + ListOf(words.List("what_was_not"));
  return page + "</html>\n";
}

}  // namespace

std::string ToText(const Certificate& certificate) {
  const Words& words = English();
  std::string text = Sentence(certificate, words) + "\n";
  for (const std::string& fact : Facts(certificate, words)) text += "  " + Printable(fact) + "\n";
  text += "\n";
  for (const SealedVerdict& trial : certificate.trials) {
    text +=
        fmt::format("{:<9} {}: {}\n", trial.refused.empty() ? "verified" : "REFUSED",
                    trial.seal ? fmt::format("{} (person {}), task {} {}, trial {}",
                                             trial.seal->name, trial.seal->person, trial.seal->task,
                                             trial.seal->exercise, trial.seal->n)
                               : Printable(trial.file),
                    Printable(VerdictOf(trial, words)));
  }
  for (const std::string& line : certificate.missing) text += "MISSING   " + Printable(line) + "\n";
  text += "\n";
  for (const std::string part : {"what_was", "what_was_not"}) {
    text += words((part + "_title").c_str()) + "\n";
    for (const std::string& line : words.List(part.c_str())) text += "  - " + line + "\n";
  }
  return text;
}

void WriteJson(const Certificate& certificate, const std::string& file) {
  WriteOutput("--json", file,
              JsonOf(certificate).dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

void WriteCertificate(const Certificate& certificate, const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw Error(folder + ": " + error.message() + "; give another --out");
  WriteOutput("--out", folder + "/certificate.txt", ToText(certificate));
  WriteJson(certificate, folder + "/certificate.json");
  for (std::size_t at = 0; at < kCertificateCatalogues.size(); ++at) {
    WriteOutput("--out", folder + "/" + PageName(at), Html(certificate, at));
  }
}

}  // namespace palpate
