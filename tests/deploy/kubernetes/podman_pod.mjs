// The pod of deploy/kubernetes/simulated-station as `podman play kube` 4.3 can run it.  That knows neither DaemonSets,
// sidecars nor probes by the kubelet, puts no words of a ConfigMap into arguments, opens no ports without a
// network, and makes an emptyDir that is root's alone, so that the pod's own /dev/shm takes its place.
//   node tests/deploy/kubernetes/podman_pod.mjs SCENE              prints it
//   node tests/deploy/kubernetes/podman_pod.mjs --probe CONTAINER  prints the words of its liveness probe, one a line
import {containersOf, manifests, podOf} from "./manifests.mjs";

const all = manifests();
const {object} = all.find(({file}) => file === "simulated-station/station.yaml");
const pod = podOf(object);

function runnable(scene) {
  const {data} = all.find(({object: each}) => each.kind === "ConfigMap").object;
  const settings = {...data, PALPATE_SCENE: scene};
  const expanded = (word) => word.replace(/\$\((PALPATE_\w+)\)/g, (_, name) => settings[name]);
  // podman names volumes for the whole host.
  const renamed = (volume) => ({...volume, name: `palpate-try-${volume.name}`});
  const isKept = ({name}) => name !== "shm";
  const spec = {
    ...pod,
    nodeSelector: undefined,
    initContainers: undefined,
    // A server or station that comes before RouDi ends, and is started again.
    restartPolicy: "Always",
    volumes: pod.volumes.filter(isKept).map(renamed),
    containers: containersOf(pod).map(
      ({startupProbe, readinessProbe, livenessProbe, restartPolicy, envFrom, ports, ...container}) => ({
        ...container,
        args: container.args?.map(expanded),
        volumeMounts: container.volumeMounts?.filter(isKept).map(renamed),
      }),
    ),
  };
  const {labels} = object.spec.template.metadata;
  return {apiVersion: "v1", kind: "Pod", metadata: {name: "palpate-try", labels}, spec};
}

const [word, name] = process.argv.slice(2);
if (word === "--probe") {
  const container = containersOf(pod).find((each) => each.name === name);
  console.log(container.livenessProbe.exec.command.join("\n"));
} else {
  console.log(JSON.stringify(runnable(word), null, 1));
}
