{{- define "seeds.pod" -}}
automountServiceAccountToken: false
securityContext:
  runAsNonRoot: true
  runAsUser: 65534
  runAsGroup: 65534
  fsGroup: 65534
  seccompProfile: { type: RuntimeDefault }
{{- end }}
{{- define "seeds.container" -}}
image: {{ .Values.image }}
imagePullPolicy: {{ .Values.imagePullPolicy }}
securityContext:
  allowPrivilegeEscalation: false
  readOnlyRootFilesystem: true
  capabilities: { drop: [ALL] }
resources:
  requests: { cpu: {{ .Values.cpu }}, memory: {{ .Values.memory }} }
  limits: { memory: {{ .Values.memory }} }
env:
  - { name: POD_IP, valueFrom: { fieldRef: { fieldPath: status.podIP } } }
  - { name: POD_INDEX, valueFrom: { fieldRef: { fieldPath: "metadata.labels['apps.kubernetes.io/pod-index']" } } }
volumeMounts:
  - { name: certs, mountPath: /certs, readOnly: true }
  - { name: scene, mountPath: /scene, readOnly: true }
  - { name: tmp, mountPath: /tmp }
{{- end }}
{{- define "seeds.volumes" -}}
- { name: scene, configMap: { name: scene } }
- { name: tmp, emptyDir: {} }
{{- end }}
