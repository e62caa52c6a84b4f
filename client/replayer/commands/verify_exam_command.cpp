#include "client/replayer/certificate/certificate.h"
#include "client/replayer/commands/commands.h"
#include "client/replayer/commands/outcome.h"

namespace palpate {
namespace {

constexpr const char* kExamExamples =
    R"(Example:
  palpate-replay verify-exam anatomy --key anatomy/exam-key.pub.pem --out cert
      verifies all submissions, on all processor cores, and computes their
      points; cert/certificate.html can be printed and signed.  Use a copy of
      the key that was made when the course began, not one that came with the
      folder.  The folder needs the exam's roll, and its exercises unchanged.
Exit status: 0 all verified; 1 something is refused, missing (also the roll)
or changed; 2 wrong usage.)";

}  // namespace

CommandLine VerifyExamCommand::AddTo(const CommandLine& app) {
  const CommandLine line =
      app.AddCommand("verify-exam", "verify all submissions of an exam, and write a certificate");
  line.Footer(kExamExamples);
  line.Add("folder", sealed.folder, "folder of the course, or a copy of it").Required();
  line.Add("--key", sealed.key, "public key of the course, exam-key.pub.pem").Required();
  line.Add("--exam", sealed.exam,
           "exam: NAME, or NAME-NUMBER as its roll is named; needed only if there are several");
  line.Add("--models", sealed.verify.models_dir, "folder of meshes, as with --verify");
  line.Add("--out", out, "folder for the certificate: text, JSON and a page to print");
  line.Add("--json", json, "write the certificate as JSON to this file; -: standard output");
  AddEffectsOption(line);
  return line;
}

int VerifyExamCommand::Run() const {
  const Certificate certificate = VerifySealed(sealed);
  Show(certificate, json);
  if (!out.empty()) {
    WriteCertificate(certificate, out);
    SayToOpen(out + "/certificate.html");
  }
  return certificate.good() ? 0 : 1;
}

}  // namespace palpate
