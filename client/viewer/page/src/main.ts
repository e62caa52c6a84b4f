import "uplot/dist/uPlot.min.css";
import "./style.css";
import "./class.css";
import "./exam.css";
import "./exercises.css";
import "./history.css";

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
