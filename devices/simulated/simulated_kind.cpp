#include "devices/device_factory.h"
#include "devices/device_kind.h"
#include "devices/simulated/simulated_phantom.h"

namespace palpate {

DeviceKind SimulatedKind() {
  DeviceKind kind{
      .name = "simulated",
      .what = "an arm by its data sheet, in a simulated hand that follows a script",
      .needs_script = true,
      .max_rate_Hz = SimulatedPhantom::kMaxRate_Hz,
      .make = [](const DeviceOptions& options) -> std::unique_ptr<Device> {
        PhantomSheet sheet = PhantomSheetOf(options.model);
        sheet.info.rate_Hz = options.rate_Hz;
        SimulatedHand hand(ScriptPlayer(*options.script, options.loop), HandImpedance{});
        return std::make_unique<SimulatedPhantom>(sheet, std::move(hand), options.script->At(0.0));
      }};
  for (const PhantomSheet& sheet : PhantomSheets()) kind.models.push_back(sheet.name);
  return kind;
}

}  // namespace palpate
