import qrcode from "qrcode-generator";

import {makeSvg} from "./elements";
import {setWords} from "./spoken";

const kQuiet = 4; // margin in modules, as the standard requires

/// Draws a text as a QR code, dark on light in every theme, because not all readers
/// accept the inverse.
export function qrSvg(text: string, label: () => string): SVGSVGElement {
  const code = qrcode(0, "M"); // the smallest size that holds the text
  code.addData(text, "Byte");
  code.make();
  const count = code.getModuleCount();
  const size = count + 2 * kQuiet;
  let path = "";
  for (let row = 0; row < count; row++) {
    for (let column = 0; column < count; column++) {
      if (code.isDark(row, column)) path += `M${column + kQuiet} ${row + kQuiet}h1v1h-1z`;
    }
  }
  const svg = makeSvg("svg", {viewBox: `0 0 ${size} ${size}`, role: "img"});
  setWords(svg, "ariaLabel", label);
  svg.append(
    makeSvg("rect", {width: String(size), height: String(size), fill: "#fff"}),
    makeSvg("path", {d: path, fill: "#000", "shape-rendering": "crispEdges"}),
  );
  return svg;
}
