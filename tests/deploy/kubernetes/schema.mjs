// What is wrong with an object by Kubernetes' API, as the package kubernetes-models has it.
import {require, modules} from "./manifests.mjs";
import {join} from "node:path";

const pathOf = ({apiVersion, kind}) => `kubernetes-models/${apiVersion}/${kind}`;

/// By its schemas: forms of text and numbers, and what is missing.  They let unknown fields pass.
function wrongByValidator(object) {
  const {[object.kind]: Model} = require(pathOf(object));
  try {
    new Model(object).validate();
    return [];
  } catch (error) {
    return [error.message];
  }
}

/// By its types, for each object a list: unknown and missing fields, and words that are not among those allowed.
/// TypeScript looks for both in an object that is written out.
function wrongByTypes(objects) {
  const ts = require("typescript");
  const name = join(modules, "manifests.ts");
  const text = objects
    .map(
      (object, i) =>
        `import type {I${object.kind} as T${i}} from "${pathOf(object)}"; ` +
        `export const object${i}: T${i} = ${JSON.stringify(object)};\n`,
    )
    .join("");
  const options = {
    noEmit: true,
    strict: true,
    skipLibCheck: true,
    types: [],
    module: ts.ModuleKind.Node16,
    moduleResolution: ts.ModuleResolutionKind.Node16,
    target: ts.ScriptTarget.ES2022,
  };
  const host = ts.createCompilerHost(options);
  const {getSourceFile, fileExists, readFile} = host;
  host.fileExists = (file) => file === name || fileExists(file);
  host.readFile = (file) => (file === name ? text : readFile(file));
  host.getSourceFile = (file, ...rest) =>
    file === name ? ts.createSourceFile(file, text, rest[0]) : getSourceFile(file, ...rest);
  const wrong = objects.map(() => []);
  for (const found of ts.getPreEmitDiagnostics(ts.createProgram([name], options, host))) {
    if (found.file?.fileName !== name) throw new Error(ts.flattenDiagnosticMessageText(found.messageText, "\n"));
    const {line} = found.file.getLineAndCharacterOfPosition(found.start);
    wrong[line].push(ts.flattenDiagnosticMessageText(found.messageText, "\n"));
  }
  return wrong;
}

/// For each object a list of what is wrong with it.
export function wrongWith(objects) {
  return wrongByTypes(objects).map((found, i) => [...found, ...wrongByValidator(objects[i])]);
}
