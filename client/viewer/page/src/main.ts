import "uplot/dist/uPlot.min.css";
import "./style.css";
import "./class.css";
import "./exercises.css";

import {App} from "./app";
import type {Probe} from "./parts/probe";

declare global {
  interface Window {
    palpate: {readonly probe: Probe};
  }
}

window.palpate = new App();
