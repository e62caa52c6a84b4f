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
  explicit Words(std::size_t at)
      : tag_(kCertificateCatalogues.at(at).first),
        all_(Json::parse(kCertificateCatalogues.at(at).second)) {}
  std::string_view tag() const { return tag_; }
  /// @param values  fmt::arg for each name in braces.
  template <class... Values>
  std::string operator()(const char* key, const Values&... values) const {
    return fmt::format(fmt::runtime(all_.at(key).get_ref<const std::string&>()), values...);
  }
  Lines List(const char* key) const { return all_.at(key).get<Lines>(); }

 private:
  std::string_view tag_;
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

/// Returns a text in a language; in English, or in any, if there is none in that.
std::string InLanguage(const LocalText& text, std::string_view language) {
  for (const std::string_view wanted : {language, std::string_view("en")}) {
    const auto found = text.find(std::string(wanted));
    if (found != text.end()) return found->second;
  }
  return text.empty() ? "" : text.begin()->second;
}

std::string WithPoint(double value, const Words& words) {
  std::string text = fmt::format("{:.1f}", value);
  std::ranges::replace(text, '.', words("decimal_point").front());
  return text;
}

/// Returns the title of an exercise; its name if its file is not the sealed one.
std::string TitleOf(const std::string& exercise, const Certificate& certificate,
                    std::string_view language) {
  const auto title = certificate.titles.find(exercise);
  return title == certificate.titles.end() ? exercise : InLanguage(title->second, language);
}

std::string PointsOf(const SealedVerdict& trial, const Words& words) {
  if (!trial.points) return "–";
  return words("by_criteria", fmt::arg("points", WithPoint(*trial.points, words)),
               fmt::arg("criteria", trial.seal->criteria_sha256.substr(0, 16)));
}

/// Returns what others did to the scene of a trial while it ran.
std::string RestorationsOf(const SealedVerdict& trial, const Words& words) {
  std::string text;
  for (const auto& [by, wish, time_s] : trial.restorations) {
    const char* const what = wish == palpate_WHOLE_AGAIN  ? "made_whole"
                             : wish == palpate_WHOLE_BACK ? "went_back"
                                                          : "set_bookmark";
    text += words(what, fmt::arg("by", Quoted(by)), fmt::arg("seconds", WithPoint(time_s, words)));
  }
  return text;
}

/// Returns a trial's verdict.  Reasons of refusal are in English: they quote files and programs.
std::string VerdictOf(const SealedVerdict& trial, const Words& words) {
  if (!trial.seal || !trial.refused.empty()) return trial.refused + RestorationsOf(trial, words);
  std::string text;
  if (trial.seal->recording.empty()) {
    text = words("nothing_recorded");
  } else if (trial.wrenches == 0) {
    text = words("nothing_done");
  } else {
    text = words("every_bit", fmt::arg("seconds", WithPoint(trial.recorded_s, words)),
                 fmt::arg("forces", trial.wrenches));
  }
  if (!trial.seal->whole) text += words("cut_short", fmt::arg("reason", trial.seal->reason));
  if (!trial.counts) text += words("does_not_count");
  return text + RestorationsOf(trial, words);
}

std::string Sentence(const Certificate& certificate, const Words& words) {
  const auto good = std::ranges::count_if(
      certificate.trials, [](const SealedVerdict& trial) { return trial.refused.empty(); });
  std::string text = words(certificate.good() ? "verified" : "not_verified", fmt::arg("good", good),
                           fmt::arg("all", certificate.trials.size()));
  if (!certificate.missing.empty()) {
    text += words("so_many_missing", fmt::arg("count", certificate.missing.size()));
  }
  if (!certificate.changed.empty()) {
    text += words("so_many_changed", fmt::arg("count", certificate.changed.size()));
  }
  return text;
}

Lines Facts(const Certificate& certificate, const Words& words) {
  const std::optional<Roll>& roll = certificate.roll;
  const std::string title = InLanguage(certificate.title, words.tag());
  const std::string exam =
      title.empty() ? certificate.exam : fmt::format("{} ({})", title, certificate.exam);
  return {words("exam", fmt::arg("exam", exam.empty() ? "–" : exam)),
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
            {"changed", certificate.changed},
            {"verified", English().List("what_was")},
            {"not_verified", English().List("what_was_not")},
            {"trials", Json::array()}};
  for (const SealedVerdict& trial : certificate.trials) {
    Json one{{"file", trial.file},           {"refused", trial.refused},
             {"wrenches", trial.wrenches},   {"recorded_s", trial.recorded_s},
             {"counts", trial.counts},       {"points", nullptr},
             {"restorations", Json::array()}};
    for (const auto& [by, wish, time_s] : trial.restorations) {
      one["restorations"].push_back(
          {{"by", by}, {"wish", static_cast<int>(wish)}, {"time_s", time_s}});
    }
    if (trial.points) one["points"] = *trial.points;
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
      one["expert_sha256"] = seal->expert_sha256;
      one["begun_s"] = seal->begun_s;
      one["ended_s"] = seal->ended_s;
      one["sealed_s"] = seal->sealed_s;
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
    "anywhere }} .refused {{ color: var(--alarm) }} a {{ color: inherit }} .sign {{ margin-top: "
    "4rem; "
    "border-bottom: 1px solid; padding-bottom: 3rem }} @media print {{ body {{ "
    "background: #fff; color: #000 }} nav {{ display: none }} }}</style><nav>{languages}</nav>"
    "<h1>{title}</h1><p><b>{sentence}</b></p>";

std::string ListOf(const Lines& lines, const char* attributes = "") {
  std::string list = fmt::format("<ul{}>", attributes);
  for (const std::string& line : lines) list += "<li>" + Escaped(line);
  return list + "</ul>\n";
}

std::string RowOf(const SealedVerdict& trial, const Certificate& certificate, const Words& words) {
  const bool good = trial.refused.empty();
  const std::string verdict = fmt::format("<td{}>{}: {}", good ? "" : " class=\"refused\"",
                                          Escaped(words(good ? "trial_verified" : "trial_refused")),
                                          Escaped(VerdictOf(trial, words)));
  if (!trial.seal) {
    return fmt::format("<tr><td colspan=\"5\">{}{}\n", Escaped(trial.file), verdict);
  }
  const Seal& seal = *trial.seal;
  const std::string title = TitleOf(seal.exercise, certificate, words.tag());
  const std::string recording = words("recording", fmt::arg("sha256", seal.sha256.substr(0, 16)));
  return fmt::format("<tr><td>{} ({})<td>{}: {}<br><code>{}</code><td>{}<td>{}<td>{}{}\n",
                     Escaped(seal.name), seal.person, seal.task, Escaped(title), Escaped(recording),
                     WhenText(seal.ended_s), WhenText(seal.sealed_s),
                     Escaped(PointsOf(trial, words)), verdict);
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
  for (const SealedVerdict& trial : certificate.trials) {
    page += RowOf(trial, certificate, words);
  }
  page += "</table>";
  for (const auto& [title, lines] :
       {std::pair("missing", &certificate.missing), std::pair("changed", &certificate.changed)}) {
    if (lines->empty()) continue;
    page += fmt::format("<h2>{}</h2>", words(title)) + ListOf(*lines, " class=\"refused\"");
  }
  page += fmt::format("<p class=\"sign\">{}</p>", Escaped(words("sign")));
  page += fmt::format("<h2>{}</h2>", words("what_was_title")) + ListOf(words.List("what_was"));
  page +=
      fmt::format("<h2>{}</h2>", words("what_was_not_title")) + ListOf(words.List("what_was_not"));
  return page + "</html>\n";
}

std::string NameOf(const SealedVerdict& trial, const Certificate& certificate) {
  if (!trial.seal) return Printable(trial.file);
  const Seal& seal = *trial.seal;
  return fmt::format("{} (person {}), task {}: {}, trial {}", seal.name, seal.person, seal.task,
                     TitleOf(seal.exercise, certificate, "en"), seal.n);
}

}  // namespace

std::string ToText(const Certificate& certificate) {
  const Words& words = English();
  std::string text = Sentence(certificate, words) + "\n";
  for (const std::string& fact : Facts(certificate, words)) text += "  " + Printable(fact) + "\n";
  text += "\n";
  for (const SealedVerdict& trial : certificate.trials) {
    text += fmt::format("{:<9} {}: {}\n", trial.refused.empty() ? "verified" : "REFUSED",
                        NameOf(trial, certificate), Printable(VerdictOf(trial, words)));
    if (!trial.seal) continue;
    text +=
        fmt::format("          ended {}, sealed {}; points: {}\n", WhenText(trial.seal->ended_s),
                    WhenText(trial.seal->sealed_s), PointsOf(trial, words));
  }
  for (const std::string& line : certificate.missing) text += "MISSING   " + Printable(line) + "\n";
  for (const std::string& line : certificate.changed) text += "CHANGED   " + Printable(line) + "\n";
  text += "\n" + words("sign") + "\n\n";
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
