// Prints the pod of deploy/kubernetes/simulated-station as `podman play kube` 4.3 can run it, which knows neither
// DaemonSets, sidecars nor probes by the kubelet, puts no words of a ConfigMap into arguments, opens no ports
// without a network, and makes an emptyDir that is root's alone (the pod's own /dev/shm takes its place):
//   node tests/deploy/kubernetes/podman_pod.mjs SCENE
import {containersOf, manifests, podOf} from "./manifests.mjs";

const scene = process.argv[2] ?? "cube";
const all = manifests();
const {object} = all.find(({file}) => file === "simulated-station/station.yaml");
const {data} = all.find(({object: each}) => each.kind === "ConfigMap").object;
const settings = {...data, PALPATE_SCENE: scene};
const expanded = (word) => word.replace(/\$\((PALPATE_\w+)\)/g, (_, name) => settings[name]);

const pod = podOf(object);
const spec = {
  ...pod,
  nodeSelector: undefined,
  initContainers: undefined,
  // A server or station that comes before RouDi ends, and is started again.
  restartPolicy: "Always",
  volumes: pod.volumes.filter(({name}) => name !== "shm"),
  containers: containersOf(pod).map(
    ({startupProbe, readinessProbe, livenessProbe, restartPolicy, envFrom, ports, ...container}) => ({
      ...container,
      volumeMounts: container.volumeMounts?.filter(({name}) => name !== "shm"),
      args: container.args?.map(expanded),
    }),
  ),
};
const {labels} = object.spec.template.metadata;
console.log(JSON.stringify({apiVersion: "v1", kind: "Pod", metadata: {name: "palpate-try", labels}, spec}, null, 1));
