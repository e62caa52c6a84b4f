import "uplot/dist/uPlot.min.css";
import "./style.css";
import "./stage.css";
import "./panel.css";
import "./replay.css";
import "./dialogs.css";

import {App} from "./app";
import type {Probe} from "./parts/probe";
import {speakToReader} from "./ui/language";

declare global {
  interface Window {
    palpate: {readonly probe: Probe};
  }
}

await speakToReader();
window.palpate = new App();
