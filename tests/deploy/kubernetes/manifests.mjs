// The manifests of deploy/kubernetes, read.
import {readFileSync, readdirSync} from "node:fs";
import {createRequire} from "node:module";
import {join, relative} from "node:path";
import {fileURLToPath} from "node:url";

export const root = fileURLToPath(new URL("../../..", import.meta.url));
export const folder = join(root, "deploy/kubernetes");
/// Where deploy/setup --for tests puts what package.json names.
export const modules = join(root, "build/kubernetes");
export const require = createRequire(join(modules, "package.json"));

function filesBelow(path) {
  return readdirSync(path, {withFileTypes: true}).flatMap((entry) =>
    entry.isDirectory() ? filesBelow(join(path, entry.name)) : [join(path, entry.name)],
  );
}

/// Every document of every file but README.md, as {file, object}, in the order of the files.
function documents() {
  const {parseAllDocuments} = require("yaml");
  return filesBelow(folder)
    .filter((file) => file.endsWith(".yaml"))
    .sort()
    .flatMap((file) =>
      parseAllDocuments(readFileSync(file, "utf8"), {merge: true}).map((document) => {
        if (document.errors.length) throw new Error(`${file}: ${document.errors[0].message}`);
        return {file: relative(folder, file), object: document.toJS()};
      }),
    );
}

/// The services of deploy/container/compose.yaml, by name, with variables at what they are by default.
export function composed() {
  const {parse} = require("yaml");
  const text = readFileSync(join(root, "deploy/container/compose.yaml"), "utf8");
  return parse(text.replace(/\$\{\w+:-([^}]*)\}/g, "$1"), {merge: true}).services;
}

const isKustomization = ({object}) => object.kind === "Kustomization";

/// `target` with the containers of a patch that adds some, which is all that the patches here do.
function patched(target, patch) {
  const result = structuredClone(target);
  result.spec.template.spec.containers.push(...patch.spec.template.spec.containers);
  return result;
}

/// What a cluster would be given: {file, object} for each; a patch as the whole that it makes.
export function manifests() {
  const all = documents();
  const patches = new Set(
    all.filter(isKustomization).flatMap(({file, object}) =>
      (object.patches ?? []).map(({path}) => join(file, "..", path)),
    ),
  );
  const objects = all.filter((each) => !isKustomization(each) && !patches.has(each.file));
  const whole = all
    .filter(({file}) => patches.has(file))
    .map(({file, object: patch}) => {
      const target = objects.find(
        ({object}) => object.kind === patch.kind && object.metadata.name === patch.metadata.name,
      );
      if (!target) throw new Error(`${file}: patches what there is not`);
      return {file, object: patched(target.object, patch)};
    });
  return [...objects, ...whole];
}

export const kustomizations = () => documents().filter(isKustomization);

/// Of a DaemonSet, Deployment or Job; undefined for all else.
export const podOf = (object) => object.spec?.template?.spec;
export const containersOf = (pod) => [...(pod.initContainers ?? []), ...pod.containers];
/// Runs as long as the pod does: a container of its own, or a sidecar.
export const isService = (pod, container) =>
  pod.restartPolicy !== "Never" && pod.containers.includes(container)
    ? true
    : container.restartPolicy === "Always";
