// The manifests of deploy/kubernetes, by Kubernetes' API and by what must hold of them here:
//   node --test tests/deploy/kubernetes      (PALPATE_BIN_DIR: the programs)
import assert from "node:assert/strict";
import {spawnSync} from "node:child_process";
import {existsSync} from "node:fs";
import {dirname, join} from "node:path";
import {describe, it} from "node:test";

import {
  composed,
  containersOf,
  folder,
  isService,
  kustomizations,
  manifests,
  modules,
  podOf,
  root,
} from "./manifests.mjs";
import {wrongWith} from "./schema.mjs";

if (!existsSync(join(modules, "node_modules"))) {
  console.log("SKIPPED: Kubernetes' schemas are not in build/kubernetes: deploy/setup --for tests fetches them from npm");
  process.exit(0);
}

const all = manifests();
const pods = all.filter(({object}) => podOf(object)).map((each) => ({...each, pod: podOf(each.object)}));
const containers = pods.flatMap(({file, pod}) =>
  containersOf(pod).map((container) => ({file, pod, container, where: `${file}: ${container.name}`})),
);
const ofKind = (kind) => all.filter(({object}) => object.kind === kind);
const matches = (labels, selector) =>
  Object.entries(selector).every(([name, value]) => labels?.[name] === value);
const podsWith = (selector) => pods.filter(({object}) => matches(object.spec.template.metadata.labels, selector));
const output = (...words) => {
  const {status, stdout, stderr} = spawnSync(words[0], words.slice(1), {encoding: "utf8"});
  assert.equal(status, 0, `${words.join(" ")}: ${stderr}`);
  return stdout;
};
const mebibytes = (quantity) => {
  const [, number, unit] = /^(\d+)(Mi|Gi)$/.exec(quantity);
  return Number(number) * (unit === "Gi" ? 1024 : 1);
};

describe("Manifests", () => {
  it("are what Kubernetes' API knows", () => {
    wrongWith(all.map(({object}) => object)).forEach((wrong, i) => {
      assert.deepEqual(wrong, [], `${all[i].file}, ${all[i].object.kind}`);
    });
  });

  it("are made wholes of by kubectl, in every folder", (test) => {
    if (spawnSync("kubectl", ["version", "--client"]).status !== 0) return test.skip("there is no kubectl");
    for (const {file} of kustomizations()) {
      assert.match(output("kubectl", "kustomize", join(folder, dirname(file))), /^kind: /m, file);
    }
  });

  it("name one image", () => {
    for (const {where, container} of containers) {
      assert.equal(container.image, "localhost/palpate:latest", where);
    }
  });

  it("call programs with flags that their help tells of", (test) => {
    const bin = process.env.PALPATE_BIN_DIR;
    if (!bin) return test.skip("PALPATE_BIN_DIR does not name the programs' folder");
    const help = new Map();
    let seen = 0;
    for (const {where, container} of containers) {
      // A shell's words stand in one string with the program's.
      const words = [...(container.command ?? []), ...(container.args ?? [])].flatMap((word) => word.split(" "));
      const program = words.find((word) => word.startsWith("palpate-"));
      if (!program) continue;
      if (!help.has(program)) help.set(program, output(join(bin, program), "--help"));
      for (const word of words.slice(words.indexOf(program)).filter((each) => /^--?[a-z]/.test(each))) {
        const flag = word.split("=")[0];
        assert.match(help.get(program), new RegExp(`(^|[\\s,])${flag}(?![-\\w])`, "m"), `${where}: ${program} has no ${flag}`);
        seen += 1;
      }
    }
    assert.ok(seen > 30, "flags were looked for");
  });

  it("give no container a right", () => {
    for (const {file, pod} of pods) {
      assert.deepEqual(
        {...pod.securityContext, fsGroup: undefined},
        {
          runAsNonRoot: true,
          runAsUser: 10001,
          runAsGroup: 10001,
          fsGroup: undefined,
          seccompProfile: {type: "RuntimeDefault"},
        },
        file,
      );
      assert.equal(pod.automountServiceAccountToken, false, file);
      for (const shared of ["hostNetwork", "hostIPC", "hostPID"]) assert.equal(pod[shared], undefined, file);
    }
    for (const {where, container} of containers) {
      assert.deepEqual(
        container.securityContext,
        {allowPrivilegeEscalation: false, readOnlyRootFilesystem: true, capabilities: {drop: ["ALL"]}},
        where,
      );
    }
  });

  it("ask for as much as they allow, and for whole cores where the loops are", () => {
    for (const {where, container} of containers) {
      assert.deepEqual(container.resources?.requests, container.resources?.limits, where);
      assert.ok(container.resources?.limits?.cpu && container.resources.limits.memory, where);
      if (["server", "station"].includes(container.name)) {
        assert.match(container.resources.limits.cpu, /^\d+$/, where);
      }
    }
  });

  it("ask whether a service does its work, but for the recorder's, which ends where it cannot", () => {
    for (const {where, pod, container} of containers) {
      if (!isService(pod, container) || container.name === "recorder") continue;
      assert.ok(container.livenessProbe ?? (pod.restartPolicy === "Never" && container.startupProbe), where);
    }
  });

  it("mount what their pod has", () => {
    for (const {where, pod, container} of containers) {
      for (const {name} of container.volumeMounts ?? []) {
        assert.ok(pod.volumes?.some((volume) => volume.name === name), `${where}: ${name}`);
      }
    }
    const claims = ofKind("PersistentVolumeClaim").map(({object}) => object.metadata.name);
    for (const {file, pod} of pods) {
      for (const {persistentVolumeClaim: claim} of pod.volumes ?? []) {
        if (claim) assert.ok(claims.includes(claim.claimName), file);
      }
    }
  });

  it("give RouDi the shared memory that its pools need", () => {
    const needed = Number(output("bash", "-c", `source '${root}/deploy/lib.sh'; shared_memory_needed_MB`));
    for (const {file, pod} of pods) {
      const roudi = containersOf(pod).find(({name}) => name === "roudi");
      if (!roudi) continue;
      const {emptyDir} = pod.volumes.find(({name}) => name === "shm");
      assert.equal(emptyDir.medium, "Memory", file);
      assert.ok(mebibytes(emptyDir.sizeLimit) >= needed, file);
      assert.ok(mebibytes(roudi.resources.limits.memory) >= mebibytes(emptyDir.sizeLimit), file);
      assert.equal(pod.shareProcessNamespace, true, `${file}: RouDi signals its clients`);
      for (const container of containersOf(pod)) {
        const words = [...(container.command ?? []), ...(container.args ?? [])].join(" ");
        if (!/--transport[ =]shm/.test(words)) continue;
        const mounted = container.volumeMounts.map(({mountPath}) => mountPath);
        for (const path of ["/dev/shm", "/tmp"]) assert.ok(mounted.includes(path), `${file}: ${container.name} ${path}`);
      }
    }
  });

  it("have selectors that select what is meant", () => {
    for (const {file, object} of pods) {
      if (object.kind === "Job") continue;
      assert.ok(matches(object.spec.template.metadata.labels, object.spec.selector.matchLabels), file);
      const chosen = podsWith(object.spec.selector.matchLabels);
      assert.ok(chosen.every((each) => each.object.metadata.name === object.metadata.name), `${file}: takes others' pods`);
    }
    for (const {file, object} of ofKind("Service")) {
      const chosen = podsWith(object.spec.selector);
      assert.ok(chosen.length > 0, file);
      for (const {targetPort, protocol = "TCP", port} of object.spec.ports) {
        for (const {pod} of chosen) {
          const target = containersOf(pod).flatMap(({ports = []}) => ports).find(({name}) => name === targetPort);
          assert.ok(target, `${file}: no port ${targetPort}`);
          assert.deepEqual([target.protocol ?? "TCP", target.containerPort], [protocol, port], file);
        }
      }
    }
    for (const {file, object} of [...ofKind("NetworkPolicy"), ...ofKind("PodDisruptionBudget")]) {
      const {matchLabels} = object.spec.podSelector ?? object.spec.selector;
      assert.ok(podsWith(matchLabels).length > 0, file);
    }
    for (const {file, object} of ofKind("HorizontalPodAutoscaler")) {
      const {kind, name} = object.spec.scaleTargetRef;
      const target = ofKind(kind).find((each) => each.object.metadata.name === name);
      assert.ok(target, file);
      assert.equal(target.object.spec.replicas, undefined, `${file}: two would decide how many`);
    }
    const denied = ofKind("NetworkPolicy").find(({object}) => object.metadata.name === "palpate-deny-all");
    assert.equal(podsWith(denied.object.spec.podSelector.matchLabels).length, pods.length);
  });

  it("open the ports of DDS that the programs have", () => {
    const {object} = ofKind("Service").find((each) => each.object.metadata.name === "palpate-server");
    const header = output("cat", join(root, "common/dds/ports.h"));
    const constant = (name) => Number(new RegExp(`${name} = (\\d+);`).exec(header)[1]);
    // Discovery of the first process, in the loop's and in the service's domain.
    const port = (domain) => constant("kFirstPort") + constant("kPortsPerDomain") * domain + 10;
    assert.deepEqual(object.spec.ports.map((each) => each.port), [port(0), port(1)]);
  });

  it("ask for names by which the gateways answer", () => {
    for (const {where, container} of containers) {
      const words = [...(container.command ?? []), ...(container.args ?? [])].join(" ");
      if (!/palpate-viewer .*--bind=0\.0\.0\.0/.test(words)) continue;
      assert.match(words, /--host-name=\$\(PALPATE_HOST_NAME\)/, `${where}: every name would get 421`);
      assert.match(words, /--max-mice=0 --no-steering/, `${where}: strangers would drive`);
    }
  });
});

describe("Containers of compose.yaml", () => {
  it("have a share of the host, no right, and of its namespaces what they are for", () => {
    const shared = {
      roudi: {network_mode: "none", ipc: "host", pid: "host"},
      server: {network_mode: "host", ipc: "host", pid: "host"},
      viewer: {network_mode: "host", ipc: undefined, pid: undefined},
    };
    for (const [name, service] of Object.entries(composed())) {
      const {network_mode, ipc, pid} = service;
      assert.deepEqual({network_mode, ipc, pid}, shared[name], name);
      assert.deepEqual(service.cap_drop, ["ALL"], name);
      assert.deepEqual([service.cap_add, service.privileged, service.devices], [undefined, undefined, undefined], name);
      assert.deepEqual(service.security_opt, ["no-new-privileges"], name);
      assert.equal(service.read_only, true, name);
      assert.match(service.user, /^[1-9]\d*:[1-9]\d*$/, name);
      for (const limit of ["mem_limit", "cpus", "pids_limit"]) assert.ok(service[limit], `${name}: ${limit}`);
      for (const tmpfs of service.tmpfs ?? []) assert.match(tmpfs, /size=\d+m/, name);
      for (const volume of service.volumes ?? []) assert.match(volume, /^(\/tmp:\/tmp|.*:ro)$/, name);
    }
  });
});
