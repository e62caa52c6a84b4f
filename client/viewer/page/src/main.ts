import "uplot/dist/uPlot.min.css";
import "./style.css";

import {App, type Probe} from "./app";

declare global {
  interface Window {
    palpate: {readonly probe: Probe};
  }
}

window.palpate = new App();
