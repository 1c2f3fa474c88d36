// a list as viewers keep it
import { ViewportPreset } from '../types';
const presets: ViewportPreset[] = [
  {
    name: 'CT-Step', gradientOpacity: '4 0 1 255 1', specularPower: '10', /* } */
    scalarOpacity: '12 -1000 0 100 0 100 0.5 300 0.5 400 0.8 3000 0.8',
    id: 'vtkMRMLVolumePropertyNode1', specular: '0.2', shade: '1', ambient: '0.1',
    colorTransfer: '12 -1000 0 0 0 250 0.8 0.5 0.25 3000 1 1 1',
    diffuse: '0.9', interpolation: '1', selectable: true,
  },
];
export default presets;
