#include "client/replayer/certificate/certificate.h"
#include "client/replayer/commands/commands.h"
#include "client/replayer/commands/outcome.h"
#include "common/error.h"

namespace palpate {

void VerifyCommand::AddTo(const CommandLine& app) {
  const Option verifies =
      app.AddFlag("--verify", given, "compute every wrench again and compare all bits");
  app.Add("--scene", verify.scene,
          "with --verify: scene to compute with; default: the recorded one, else that of the "
          "catalogue")
      .Needs(verifies);
  app.Add("--models", verify.models_dir,
          "with --verify: folder of meshes that no package installs; the environment variable "
          "PALPATE_MODELS has the same effect")
      .Needs(verifies);
  app.Add("--json", json,
          "with --verify: write the result as JSON to this file; -: standard output");
  app.Add("--key", key,
          "with --verify: also check the recording's seal with this public key of the course, "
          "exam-key.pub.pem")
      .Needs(verifies);
}

void VerifyCommand::Check() const {
  if (key && files.size() != 1) {
    throw UsageError("--key: a sealed recording is a single file; give one file only");
  }
  if (!json.empty() && !given) {
    throw UsageError("--json needs --verify; add it, or use a command such as score");
  }
}

int VerifyCommand::Run() const {
  if (key) {
    const Certificate certificate =
        VerifySealed({.recording = files.front(), .key = *key, .verify = verify});
    Show(certificate, json);
    return certificate.good() ? 0 : 1;
  }
  const Verification verification = Verify(files, verify);
  Show(verification, json);
  return verification.good() ? 0 : 1;
}

}  // namespace palpate
